"""Bosphorus ``.bnt`` scans and their ``.lm2`` / ``.lm3`` landmarks.

A scan is little-endian: u16 rows, u16 columns, f64 z of an invalid point, u16 length and name
of a picture, u32 n = 5 · rows · columns, then the planes X, Y, Z, u, v in f64, bottom row
first. Millimetres, y up, z towards the viewer. Points at or below the stated z are invalid.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud
from rangeface.io._source import Limits, Source

_HEAD = struct.Struct("<HHdH")


def recognise(source: Source) -> bool:
    """The count behind the name is five times rows times columns."""
    if len(source.data) < _HEAD.size:
        return False
    rows, columns, zmin, length = _HEAD.unpack_from(source.data)
    end = _HEAD.size + length
    if not (rows and columns and length < 1024 and np.isfinite(zmin)) or end + 4 > len(source.data):
        return source.path.suffix.lower() == ".bnt"
    (count,) = struct.unpack_from("<I", source.data, end)
    return bool(count == 5 * rows * columns)


def parse(source: Source) -> Cloud:
    """The grid of points, top row first, NaN where invalid."""
    source.need(0, _HEAD.size, "the header")
    rows, columns, zmin, length = _HEAD.unpack_from(source.data)
    start = _HEAD.size + length + 4
    source.need(_HEAD.size, length + 4, "the name")
    source.cap_pixels(columns, rows)
    (count,) = struct.unpack_from("<I", source.data, start - 4)
    if count != 5 * rows * columns:
        raise source.error(
            ScanFault.WRONG_SIZE, f"{count} values, 5 × {rows} × {columns} are expected"
        )
    source.need(start, 8 * count, f"{count} values")
    planes = np.frombuffer(source.data, "<f8", 3 * rows * columns, start)
    points = np.stack(list(planes.reshape(3, rows, columns)[:, ::-1]), axis=2)
    points[~(points[..., 2] > zmin), 2] = np.nan
    return Cloud(points)


def read_landmarks(path: str | Path) -> dict[str, NDArray[np.float64]]:
    """Read the landmarks of a Bosphorus scan.

    Parameters
    ----------
    path : str or Path
        An ``.lm3`` file (points in the scan's mm) or an ``.lm2`` file (pixels of the picture).

    Returns
    -------
    dict of str to (3,) or (2,) float64
        By the database's names, lower case with underscores (``nose_tip``, …). Points of an
        ``.lm3`` are in the camera frame, mm; pixels of an ``.lm2`` are as stated.

    Raises
    ------
    ScanError
        The file is missing, or a name is not followed by its coordinates.
    """
    source = Source.open(path, Limits(max_bytes=1 << 20))
    name = ""
    marks: dict[str, NDArray[np.float64]] = {}
    for line in re.split(r"[\r\n]+", source.data.decode("latin-1")):
        words = line.split("#")[0].replace(",", " ").split()
        try:
            values = np.array([float(w) for w in words])
        except ValueError:
            name = "_".join(words).lower().rstrip(":")
            continue
        if len(values) in (2, 3) and name:
            flip = (1.0, -1.0, -1.0) if len(values) == 3 else 1.0
            marks[name], name = values * flip, ""
        elif len(values):
            raise source.error(ScanFault.MALFORMED, f"{line[:40]!r} after {name!r}")
    if not marks:
        raise source.error(ScanFault.MALFORMED, "no landmark")
    return marks
