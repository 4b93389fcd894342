"""STL, binary and ascii: triangles, whose equal corners become one point again.

The format states no unit and no viewpoint: a file is read as millimetres, y up, z towards the
viewer, unless the caller says otherwise.
"""

from __future__ import annotations

import re

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud
from rangeface.io._source import Source
from rangeface.numerics.text import numbers

_ROW = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_SOLID = re.compile(rb"\s*solid\b[^\r\n]*[\r\n]+(?:\s*#[^\r\n]*[\r\n]+)*\s*(facet|endsolid)", re.I)


def recognise(source: Source) -> bool:
    """The opening of an ascii file, or a binary one whose size fits its count."""
    return _SOLID.match(source.data[:1024]) is not None or _is_binary(source)


def parse(source: Source) -> Cloud:
    """Points and triangles."""
    binary = _is_binary(source)  # some binary files begin with "solid" too
    corners = _binary(source) if binary else _ascii(source)
    source.cap_points(len(corners) // 3, "triangles")
    if not len(corners):
        raise source.error(ScanFault.NO_VALID_PIXELS, "no triangles")
    rows = np.ascontiguousarray(corners, dtype=np.float32) + 0.0  # −0 = 0
    keys = rows.view(np.dtype((np.void, 12))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return Cloud(rows[first], inverse.reshape(-1, 3))


def _is_binary(source: Source) -> bool:
    """Whether the declared triangles fill the file, or would if it were whole."""
    if len(source.data) < 84:
        return False
    count = int(np.frombuffer(source.data, "<u4", 1, 80)[0])
    whole = 84 + count * _ROW.itemsize
    exact = count > 0 and len(source.data) == whole
    return exact or (source.path.suffix.lower() == ".stl" and not _SOLID.match(source.data[:1024]))


def _binary(source: Source) -> NDArray[np.float32]:
    count = int(np.frombuffer(source.data, "<u4", 1, 80)[0])
    source.cap_points(count, "triangles")
    source.need(84, count * _ROW.itemsize, f"{count} triangles")
    return np.frombuffer(source.data, _ROW, count, 84)["corners"].reshape(-1, 3)


def _ascii(source: Source) -> NDArray[np.float64]:
    text = source.array
    if not re.search(rb"end\s*solid", source.data[-512:], re.IGNORECASE):
        raise source.error(ScanFault.TRUNCATED, "no endsolid at the end")
    clean, count = _vertices_only(text)
    source.cap_points(count // 3, "triangles")
    values, _ = numbers(clean, 0, 3 * count, comment="")
    if len(values) < 3 * count or count % 3:
        raise source.error(ScanFault.MALFORMED, f"{count} corners, {len(values)} coordinates")
    return values.reshape(-1, 3)


@njit(cache=True, nogil=True)
def _vertices_only(text: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], int]:
    """The lines that begin with "vertex", without the word, and how many there are."""
    out = np.empty(len(text) + 1, dtype=np.uint8)
    used, count, i, n = 0, 0, 0, len(text)
    word = (118, 101, 114, 116, 101, 120)
    while i < n:
        while i < n and text[i] <= 32:
            i += 1
        same = i + 6 < n
        for k in range(6):
            same = same and (text[i + k] | 32) == word[k]
        if same:
            i += 6
            count += 1
        while i < n and text[i] != 10 and text[i] != 13:
            if same:
                out[used] = text[i]
                used += 1
            i += 1
        if same:
            out[used] = 10
            used += 1
    return out[:used], count
