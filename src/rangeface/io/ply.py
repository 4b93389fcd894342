"""PLY (Turk 1994): ascii, binary of either byte order, and range grids.

The format states no unit and no viewpoint: a file is read as millimetres, y up, z towards the
viewer, unless the caller says otherwise. A range grid (``obj_info num_cols``, element
``range_grid``) keeps its rows and columns.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud, check_indices
from rangeface.io._source import Source
from rangeface.numerics import rows as walk
from rangeface.numerics.polygons import fan
from rangeface.numerics.text import numbers

_NAMES = ["char", "uchar", "short", "ushort", "int", "uint", "float", "double"]
_SIZED = ["int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"]
_TYPES = {name: code for names in (_NAMES, _SIZED) for code, name in enumerate(names)}
_DTYPES = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_INDEX_NAMES = ("vertex_indices", "vertex_index")
_MAX_HEADER = 1 << 16
_MAX_PROPERTIES = 256


@dataclass
class _Element:
    name: str
    count: int
    names: list[str] = field(default_factory=list)
    layout: list[tuple[int, int]] = field(default_factory=list)  # (count type or −1, type)

    @property
    def has_lists(self) -> bool:
        return any(count >= 0 for count, _ in self.layout)

    @property
    def indices(self) -> int:
        """Position of the list that names vertices, −1 if there is none."""
        return next((self.names.index(n) for n in _INDEX_NAMES if n in self.names), -1)


@dataclass
class _Header:
    order: str
    elements: list[_Element]
    info: dict[str, str]
    stop: int


def recognise(source: Source) -> bool:
    """The word "ply" on a line of its own."""
    return source.data[:3] == b"ply" and source.data[3:4] in (b"\n", b"\r", b" ")


def parse(source: Source) -> Cloud:
    """Vertices, faces cut into triangles, and the grid if it has one."""
    header = _header(source)
    reader = _Text(source, header) if header.order == "" else _Binary(source, header)
    points, triangles, grid = None, None, None
    for element in header.elements:
        if element.name == "vertex" and points is None:
            points = reader.vertices(element)
        elif element.name == "face" and element.indices >= 0:
            sizes, corners = reader.lists(element)
            triangles = corners.reshape(-1, 3) if (sizes == 3).all() else fan(corners, sizes)
        elif element.name == "tristrips" and element.indices >= 0:
            triangles = walk.strip_triangles(reader.lists(element)[1])
        elif element.name == "range_grid" and element.indices >= 0:
            grid = reader.lists(element)
        else:
            reader.skip(element)
    if points is None:
        raise source.error(ScanFault.MALFORMED, "no element vertex")
    if grid is not None:
        return Cloud(_grid(source, header, points, *grid))
    return Cloud(points, triangles)


def _header(source: Source) -> _Header:
    end = re.search(rb"(?:\n|\r)[ \t]*end_header[ \t]*(\r\n|\n|\r)", source.data[:_MAX_HEADER])
    if end is None:
        raise source.error(ScanFault.TRUNCATED, "the header has no end_header")
    text = source.data[: end.start()].decode("latin-1")
    order: str | None = None
    elements: list[_Element] = []
    info: dict[str, str] = {}
    for line in re.split(r"\r\n|\r|\n", text)[1:]:
        match line.split():
            case ["format", kind, *_] if kind in _FORMATS:
                order = _FORMATS[kind]
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append(_Element(name, int(count[:18])))
            case ["property", "list", count, kind, name] if elements and _known(count, kind):
                _add(source, elements[-1], name, _TYPES[count], _TYPES[kind])
            case ["property", kind, name] if elements and kind in _TYPES:
                _add(source, elements[-1], name, -1, _TYPES[kind])
            case ["obj_info", name, value]:
                info[name] = value
            case [] | ["comment", *_] | ["obj_info", *_]:
                pass
            case _:
                raise source.error(ScanFault.MALFORMED, f"header line {line[:60]!r}")
    if order is None:
        raise source.error(ScanFault.MALFORMED, "the header names no known format")
    return _Header(order, elements, info, end.end())


def _known(count: str, kind: str) -> bool:
    return _TYPES.get(count, 6) < 6 and kind in _TYPES


def _add(source: Source, element: _Element, name: str, count: int, kind: int) -> None:
    if len(element.names) >= _MAX_PROPERTIES:
        raise source.error(ScanFault.TOO_LARGE, f"more than {_MAX_PROPERTIES} properties")
    element.names.append(name)
    element.layout.append((count, kind))


class _Reader:
    """The elements of a file, read in their order."""

    def __init__(self, source: Source, header: _Header) -> None:
        self.source = source
        self.at = header.stop
        self.order = header.order

    def vertices(self, element: _Element) -> NDArray[np.floating]:
        """Columns x, y, z of the element, (n, 3)."""
        missing = [axis for axis in "xyz" if axis not in element.names]
        if missing or element.has_lists:
            what = f"no property {missing[0]}" if missing else "a list property"
            raise self.source.error(ScanFault.MALFORMED, f"vertex has {what}")
        self.source.cap_points(element.count)
        return self.columns(element)

    def columns(self, element: _Element) -> NDArray[np.floating]:
        raise NotImplementedError

    def lists(self, element: _Element) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Lengths (n,) and values of the element's vertex lists, end to end."""
        self.source.cap_points(element.count, f"rows of {element.name}")
        if element.layout[element.indices][0] < 0 or element.layout[element.indices][1] >= 6:
            raise self.source.error(ScanFault.MALFORMED, f"{element.name}: no list of integers")
        return self.walk(element, element.indices)

    def skip(self, element: _Element) -> None:
        """Pass over an element."""
        if element.layout and element.count:
            self.walk(element, -1)

    def walk(self, element: _Element, wanted: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        raise NotImplementedError

    def short(self, element: _Element, done: int) -> Exception:
        """The error of an element that ends early."""
        return self.source.error(
            ScanFault.TRUNCATED, f"{done} of {element.count} rows of {element.name} are there"
        )


class _Binary(_Reader):
    def columns(self, element: _Element) -> NDArray[np.floating]:
        kinds = [self.order + _DTYPES[kind] for _, kind in element.layout]
        offsets = np.cumsum([0, *(np.dtype(k).itemsize for k in kinds)])
        stride = int(offsets[-1])
        if element.count * stride > len(self.source.data) - self.at:
            raise self.short(element, (len(self.source.data) - self.at) // stride)
        which = [element.names.index(axis) for axis in "xyz"]
        row = np.dtype(
            {
                "names": list("xyz"),
                "formats": [kinds[i] for i in which],
                "offsets": [int(offsets[i]) for i in which],
                "itemsize": stride,
            }
        )
        table = np.frombuffer(self.source.data, row, element.count, self.at)
        self.at += element.count * stride
        return np.stack([table[axis].astype(np.float64) for axis in "xyz"], axis=1)

    def walk(self, element: _Element, wanted: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        alike = self.alike(element) if wanted >= 0 else None
        if alike is not None:
            return alike
        self.source.need(self.at, element.count, f"{element.count} rows of {element.name}")
        layout = np.array(element.layout, dtype=np.int64).reshape(-1, 2)
        counts = np.zeros(element.count if wanted >= 0 else 0, dtype=np.int64)
        items = np.empty(min(4 * len(counts), len(self.source.data) - self.at), dtype=np.int64)
        data, big = self.source.array, self.order == ">"
        where = (data, self.at, element.count, layout, wanted, big, walk.SIZES)
        done, stop, total = walk.walk_binary(*where, counts, items)
        if done < element.count:
            raise self.short(element, done)
        self.source.cap_points(total // 4, "face corners / 4")
        if total > len(items):  # many corners a face: again, with room for all
            items = np.empty(total, dtype=np.int64)
            walk.walk_binary(*where, counts, items)
        self.at = stop
        return counts, items[:total]

    def alike(self, element: _Element) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
        """The only list of an element at once, where all rows have as many values as the first."""
        [(_, value), *others] = element.layout
        data = self.source.array[self.at :]
        if others or element.layout[0][0] > 1 or not element.count or not len(data):
            return None
        kind = np.dtype(self.order + _DTYPES[value])
        row = np.dtype([("n", "u1"), ("items", kind, (int(data[0]),))])
        if element.count * row.itemsize > len(data):
            return None
        table = np.frombuffer(data, row, element.count)
        if not (table["n"] == data[0]).all():
            return None
        self.at += element.count * row.itemsize
        return table["n"].astype(np.int64), table["items"].astype(np.int64).ravel()


class _Text(_Reader):
    def columns(self, element: _Element) -> NDArray[np.floating]:
        width = len(element.names)
        self.source.need(self.at, 2 * element.count * width - 1, "the vertices")
        values, self.at = numbers(self.source.array, self.at, element.count * width, comment="")
        if len(values) < element.count * width:
            raise self.short(element, len(values) // width)
        table = values.reshape(element.count, width)
        return table[:, [element.names.index(axis) for axis in "xyz"]]

    def walk(self, element: _Element, wanted: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        is_list = np.array([count >= 0 for count, _ in element.layout])
        present = (len(self.source.data) - self.at) // 2 + 1
        if not is_list.any():
            present = min(present, element.count * len(is_list))
        most = 6 * self.source.limits.max_points
        values, _ = numbers(self.source.array, self.at, min(present, most), comment="")
        none = np.empty(0, dtype=np.int64)
        done, stop, total = walk.walk_numbers(values, 0, element.count, is_list, wanted, none, none)
        if done < element.count:
            raise self.short(element, done)
        counts = np.zeros(element.count if wanted >= 0 else 0, dtype=np.int64)
        items = np.empty(total, dtype=np.int64)
        if wanted >= 0:
            walk.walk_numbers(values, 0, element.count, is_list, wanted, counts, items)
        _, self.at = numbers(self.source.array, self.at, stop, comment="")
        return counts, items


def _grid(
    source: Source,
    header: _Header,
    points: NDArray[np.floating],
    counts: NDArray[np.int64],
    items: NDArray[np.int64],
) -> NDArray[np.floating]:
    """Points on their grid (H, W, 3), NaN where a cell names no vertex."""
    try:
        width, height = int(header.info["num_cols"]), int(header.info["num_rows"])
    except (KeyError, ValueError):
        raise source.error(ScanFault.MALFORMED, "a range grid without num_cols, num_rows") from None
    source.cap_pixels(width, height)
    if width * height != len(counts) or counts.max(initial=0) > 1:
        raise source.error(
            ScanFault.WRONG_SIZE, f"{len(counts)} cells in a grid of {width} × {height}"
        )
    out = np.full((height * width, 3), np.nan)
    out[counts == 1] = points[check_indices(source, items, len(points))]
    return out.reshape(height, width, 3)
