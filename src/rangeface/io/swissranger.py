"""SwissRanger ``.dat`` logs: text planes under ``%`` titles.

The planes are distance z, x and y vectors in metres, amplitude and a confidence map, 144 rows
of 176 numbers; titles are spelt in several ways and planes may be missing. The camera is
fitted to the x and y vectors; without them the nominal SR-3000 stands in (8 mm lens, 40 µm
pixels), or what the caller states.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._grid import fit_pinhole
from rangeface.io._source import Source
from rangeface.io.camera_toml import depth_image
from rangeface.numerics.lines import first_line
from rangeface.numerics.text import numbers
from rangeface.types import Pinhole, RangeImage

_TITLE = re.compile(rb"(?:^|[\r\n])[ \t]*+(?:[%#][ \t]*+)?([A-Za-z][^\r\n]*+)")
_PLANES = {
    "z": ("distance", "depth", "zvector", "zcoord"),
    "x": ("xvector", "xcoord", "calibratedx"),
    "y": ("yvector", "ycoord", "calibratedy"),
    "amplitude": ("amplitude", "intensity"),
    "confidence": ("confidence",),
}
_ROWS, _COLUMNS = 144, 176
_FOCAL_PX = 200.0


def recognise(source: Source) -> bool:
    """A ``%`` or ``#`` title with the name of a plane, then numbers."""
    head = source.data[:2048]
    if b"\0" in head or not re.match(rb"\s*[%#]?[ \t]*[A-Za-z]", head):
        return False
    for title in _TITLE.finditer(head):
        if _plane(title[1]):
            row, _ = first_line(source.array, title.end(), _COLUMNS)
            if len(row) == 1 or len(row) >= 16:  # a list of points has a few columns
                return True
    return False


def parse(source: Source) -> RangeImage:
    """Depth and amplitude of the first frame."""
    planes: dict[str, NDArray[np.float64]] = {}
    for title in _TITLE.finditer(source.data):
        name = _plane(title[1])
        first, _ = first_line(source.array, title.end(), 4096)
        if name and name not in planes and len(first):  # else a title with another below it
            planes[name] = _read(source, title.end(), name, planes.get("z"))
        if len(planes) == len(_PLANES):
            break
    if "z" not in planes:
        raise source.error(ScanFault.MALFORMED, "no plane of distances")
    image = depth_image(source, planes["z"], unit="m", camera=_camera(source, planes))
    return RangeImage(image.depth, image.camera, amplitude=_amplitude(planes))


def _plane(title: bytes) -> str:
    """Which plane a title announces, "" for none."""
    word = re.sub(rb"[^a-z]", b"", title[:80].lower()).decode()
    return next((p for p, names in _PLANES.items() if any(n in word for n in names)), "")


def _read(
    source: Source, start: int, name: str, like: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    first, _ = first_line(source.array, start, 4096)
    rows, columns = like.shape if like is not None else (_ROWS, _COLUMNS)
    if like is None and len(first) not in (1, _COLUMNS, _ROWS * _COLUMNS):
        columns = max(len(first), 1)
        end = _TITLE.search(source.data, start)
        stop = end.start() if end else len(source.data)
        present, _ = numbers(source.array[:stop], start, source.limits.max_pixels, commas=True)
        rows = len(present) // columns
    source.cap_pixels(columns, rows)
    values, _ = numbers(source.array, start, rows * columns, commas=True)
    if len(values) < rows * columns:
        raise source.error(
            ScanFault.TRUNCATED, f"plane {name}: {len(values)} of {rows} × {columns} numbers"
        )
    return values.reshape(rows, columns)


def _camera(source: Source, planes: dict[str, NDArray[np.float64]]) -> Pinhole:
    z = planes["z"]
    height, width = z.shape
    if "x" in planes and "y" in planes:
        x, y = (_rightward(planes[name], z, axis) for name, axis in (("x", 1), ("y", 0)))
        found = fit_pinhole(np.stack([x, y, np.where(z > 0, z, np.nan)], axis=2), max_error_px=1.0)
        if found is not None:
            return found
    return Pinhole(_FOCAL_PX, _FOCAL_PX, (width - 1) / 2, (height - 1) / 2, width, height)


def _rightward(
    plane: NDArray[np.float64], z: NDArray[np.float64], axis: int
) -> NDArray[np.float64]:
    """The plane, its sign such that it grows with the column or the row."""
    index = np.broadcast_to(
        np.expand_dims(np.arange(z.shape[axis]), 1 - axis), z.shape
    ) - (z.shape[axis] - 1) / 2  # fmt: skip
    valid = np.isfinite(plane) & np.isfinite(z) & (z > 0)
    return plane * (1.0 if float((plane * index)[valid].sum()) >= 0 else -1.0)


def _amplitude(planes: dict[str, NDArray[np.float64]]) -> NDArray[np.float32] | None:
    amplitude = planes.get("amplitude")
    if amplitude is None or amplitude.shape != planes["z"].shape:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        return np.where(np.isfinite(amplitude), amplitude, np.nan).astype(np.float32)
