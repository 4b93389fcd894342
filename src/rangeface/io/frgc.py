"""FRGC / UND ``.abs``, plain or in gzip: a grid of points as text.

``480 rows``, ``640 columns``, ``pixels (flag X Y Z):`` and four blocks of numbers: whether a
pixel is valid, X, Y, Z. Millimetres, y up, z towards the viewer. Only the flag is trusted: an
invalid point is −999999 with one writer and 0 with another.
"""

from __future__ import annotations

import re

import numpy as np

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud
from rangeface.io._source import Source
from rangeface.numerics.text import numbers

_HEADER = re.compile(
    rb"\s*(\d{1,9})\s*rows\s+(\d{1,9})\s*col(?:umn)?s\s+pixels\s*\(\s*flag\s+x\s+y\s+z\s*\)\s*:?",
    re.IGNORECASE,
)


def recognise(source: Source) -> bool:
    """The three lines of the header, however spaced."""
    return re.match(rb"\s*\d{1,9}\s*rows\s+\d", source.data[:256], re.IGNORECASE) is not None


def parse(source: Source) -> Cloud:
    """The grid of points, NaN where the flag is 0."""
    header = _HEADER.match(source.data[:512])
    if header is None:
        raise source.error(ScanFault.MALFORMED, "the header is not rows, columns, pixels")
    rows, columns = int(header[1]), int(header[2])
    source.cap_pixels(columns, rows)
    count = rows * columns
    source.need(header.end(), 8 * count - 1, f"four blocks of {count} numbers")
    values, stop = numbers(source.array, header.end(), 4 * count, comment="")
    if len(values) < 4 * count:
        bad = source.data[stop : stop + 12]
        fault = ScanFault.MALFORMED if bad else ScanFault.TRUNCATED
        raise source.error(fault, f"{len(values)} of {4 * count} numbers, then {bad!r}")
    blocks = values.reshape(4, rows, columns)
    points = np.stack(list(blocks[1:]), axis=2)
    points[~(blocks[0] > 0), 2] = np.nan
    return Cloud(points)
