"""OFF (Geomview): vertices and polygons in text, with or without normals and colours.

The format states no unit and no viewpoint: a file is read as millimetres, y up, z towards the
viewer, unless the caller says otherwise.
"""

from __future__ import annotations

import re

import numpy as np

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud
from rangeface.io._source import Source
from rangeface.numerics.lines import first_line, read_polygons, read_table
from rangeface.numerics.polygons import fan

_HEADER = re.compile(
    rb"(?:\s*#[^\r\n]*[\r\n])*\s*(?:ST)?C?N?(4)?(n)?OFF\b[ \t]*(BINARY)?", re.IGNORECASE
)


def recognise(source: Source) -> bool:
    """The word OFF, with the letters that Geomview allows before it."""
    return _HEADER.match(source.data[:512]) is not None


def parse(source: Source) -> Cloud:
    """Vertices, and faces cut into triangles; edges and colours are passed over."""
    header = _HEADER.match(source.data[:512])
    assert header is not None
    if any(header.groups()):
        raise source.error(ScanFault.UNSUPPORTED, "binary or not three-dimensional OFF")
    text = source.array
    counts, at = first_line(text, header.end(), 3)
    if len(counts) < 2 or not (np.abs(counts) < 2**40).all():
        raise source.error(ScanFault.MALFORMED, "no numbers of vertices and faces")
    vertices, faces = int(counts[0]), int(counts[1])
    source.cap_points(vertices)
    source.cap_points(faces, "faces")
    source.need(at, 6 * vertices + 2 * faces, "the vertices and faces")
    points, at = read_table(text, at, vertices, 3)
    if len(points) < vertices:
        raise source.error(ScanFault.TRUNCATED, f"{len(points)} of {vertices} vertices can be read")
    sizes, indices, _ = read_polygons(text, at, faces)
    if len(sizes) < faces:
        raise source.error(ScanFault.TRUNCATED, f"{len(sizes)} of {faces} faces can be read")
    return Cloud(points, fan(indices, sizes) if faces else None)
