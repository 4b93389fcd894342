"""Wavefront OBJ: vertices and polygons; materials, normals and textures are passed over.

The format states no unit and no viewpoint: a file is read as millimetres, y up, z towards the
viewer, unless the caller says otherwise. Negative indices count back from the last vertex.
"""

from __future__ import annotations

import re

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud
from rangeface.io._source import Source
from rangeface.numerics.polygons import fan
from rangeface.numerics.text import number_at

_VERTEX = re.compile(rb"(?:^|[\r\n])[ \t]*v[ \t]+[-+.\dnNiI][^\s]*[ \t]+[-+.\dnNiI]")


def recognise(source: Source) -> bool:
    """A line ``v x y z`` within the first 64 KiB of a text."""
    return b"\0" not in source.data[:1024] and _VERTEX.search(source.data[: 1 << 16]) is not None


def parse(source: Source) -> Cloud:
    """All vertices, and all faces cut into triangles."""
    text = source.array
    vertices, faces, corners = _count(text)
    source.cap_points(vertices)
    source.cap_points(faces, "faces")
    source.cap_points(corners // 4, "face corners / 4")
    points = np.full((vertices, 3), np.nan)
    sizes = np.empty(faces, dtype=np.int64)
    indices = np.empty(corners, dtype=np.int64)
    wrong, corners = _fill(text, points, sizes, indices)
    if wrong >= 0:
        line = 1 + source.data.count(b"\n", 0, wrong)
        raise source.error(ScanFault.MALFORMED, f"line {line} cannot be read")
    return Cloud(points, fan(indices[:corners], sizes) if faces else None)


@njit(cache=True, nogil=True)
def _line_end(text: NDArray[np.uint8], i: int) -> int:
    """End of the logical line: a backslash before the line's end joins the next one."""
    n = len(text)
    while i < n and text[i] != 10 and text[i] != 13:
        if text[i] == ord("\\") and i + 1 < n and (text[i + 1] == 10 or text[i + 1] == 13):
            i += 2 if i + 2 < n and text[i + 1] == 13 and text[i + 2] == 10 else 1
        i += 1
    return i


@njit(cache=True, nogil=True)
def _blank(c: int) -> bool:
    return c == 32 or c == 9 or c == 10 or c == 13 or c == ord("\\")


@njit(cache=True, nogil=True)
def _keyword(text: NDArray[np.uint8], i: int, stop: int) -> int:
    """118 ("v") or 102 ("f", or its old name "fo") where a line starts so, else 0."""
    if i + 1 >= stop:
        return 0
    if (text[i] == 118 or text[i] == 102) and _blank(text[i + 1]):
        return text[i]
    if i + 2 < stop and text[i] == 102 and text[i + 1] == 111 and _blank(text[i + 2]):
        return 102
    return 0


@njit(cache=True, nogil=True)
def _count(text: NDArray[np.uint8]) -> tuple[int, int, int]:
    """Vertices, faces, and a bound of the faces' corners."""
    i, n, vertices, faces, corners = 0, len(text), 0, 0, 0
    while i < n:
        while i < n and _blank(text[i]):
            i += 1
        stop = _line_end(text, i)
        kind = _keyword(text, i, stop)
        if kind == 118:
            vertices += 1
        elif kind == 102:
            faces += 1
            for k in range(i + 1, stop):
                corners += not _blank(text[k]) and _blank(text[k - 1])
        i = stop + 1
    return vertices, faces, corners


@njit(cache=True, nogil=True)
def _fill(
    text: NDArray[np.uint8],
    points: NDArray[np.float64],
    sizes: NDArray[np.int64],
    indices: NDArray[np.int64],
) -> tuple[int, int]:
    """Fill the arrays; offset of a line that cannot be read or −1, and the corners found."""
    i, n, vertex, face, corner = 0, len(text), 0, 0, 0
    while i < n:
        while i < n and _blank(text[i]):
            i += 1
        stop = _line_end(text, i)
        kind = _keyword(text, i, stop)
        at = i + 1 + (kind == 102 and text[i + 1] == 111) if kind else stop
        count = 0
        while at < stop:
            while at < stop and _blank(text[at]):
                at += 1
            end = at
            while end < stop and not _blank(text[end]):
                end += 1
            if end == at or text[at] == ord("#") or (kind == 118 and count == 3):
                break
            cut = at
            while cut < end and not (kind == 102 and text[cut] == ord("/")):
                cut += 1
            if cut == at:
                return i, corner
            value, good = number_at(text, at, cut)
            if not good:
                return i, corner
            if kind == 118:
                points[vertex, count] = value
            else:
                if not abs(value) < 2**53 or value == 0.0:
                    return i, corner
                indices[corner] = int(value) - 1 if value > 0 else vertex + int(value)
                corner += 1
            count += 1
            at = end
        if kind == 118:
            if count < 3:
                return i, corner
            vertex += 1
        elif kind == 102:
            sizes[face] = count
            face += 1
        i = stop + 1
    return -1, corner
