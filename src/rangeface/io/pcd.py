"""PCD (Point Cloud Library 0.5 to 0.7): ascii, binary and binary_compressed, organised or not.

Points are read as ROS and PCL write them: metres in the camera's axes (x right, y down, z
forward). An organised cloud keeps its rows and columns; the viewpoint is not applied.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud
from rangeface.io._source import Source
from rangeface.numerics.lines import read_table

_MAX_HEADER = 1 << 14
_MAX_STRIDE = 1 << 16
_DATA = re.compile(rb"(?:^|[\r\n])[ \t]*DATA[ \t]+(\w+)[ \t]*(\r\n|\n|\r|$)")
_KEYS = ("VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "POINTS")


@dataclass
class _Header:
    names: list[str]
    kinds: list[str]
    counts: list[int]
    width: int
    height: int
    data: str
    stop: int

    @property
    def offsets(self) -> list[int]:
        """Bytes before each field in a row, and the length of the row."""
        sizes = [np.dtype(k).itemsize * c for k, c in zip(self.kinds, self.counts, strict=True)]
        return [0, *np.cumsum(sizes).tolist()]

    @property
    def axes(self) -> list[int]:
        """Which fields are x, y and z."""
        return [self.names.index(axis) for axis in "xyz"]


def recognise(source: Source) -> bool:
    """A line DATA after a line FIELDS, as text."""
    head = source.data[:_MAX_HEADER]
    return re.search(rb"(?:^|[\r\n])[ \t]*(?:FIELDS|COLUMNS)[ \t]", head[:2048]) is not None or (
        head.startswith(b"# .PCD")
    )


def parse(source: Source) -> Cloud:
    """The points, on their grid if they have one."""
    header = _header(source)
    count = header.width * header.height
    source.cap_points(count)
    if header.data == "ascii":
        points = _ascii(source, header, count)
    elif header.data == "binary":
        points = _columns(source, header, count, header.stop, source.data, packed=False)
    elif header.data == "binary_compressed":
        source.need(header.stop, 8, "the compressed size")
        packed, expanded = struct.unpack_from("<II", source.data, header.stop)
        source.need(header.stop + 8, packed, "the compressed points")
        if expanded > source.limits.expanded(packed) or expanded > header.offsets[-1] * count:
            raise source.error(ScanFault.TOO_LARGE, f"{packed} bytes expand to {expanded}")
        body = source.array[header.stop + 8 : header.stop + 8 + packed]
        raw = _expand(body, expanded)
        if len(raw) < expanded:
            raise source.error(ScanFault.MALFORMED, f"{len(raw)} of {expanded} bytes expand")
        points = _columns(source, header, count, 0, raw.tobytes(), packed=True)
    else:
        raise source.error(ScanFault.UNSUPPORTED, f"DATA {header.data}")
    return Cloud(points.reshape(header.height, header.width, 3) if header.height > 1 else points)


def _header(source: Source) -> _Header:
    data = _DATA.search(source.data[:_MAX_HEADER])
    if data is None:
        raise source.error(ScanFault.TRUNCATED, "the header has no line DATA")
    lines: dict[str, list[str]] = {}
    for line in re.split(r"[\r\n]+", source.data[: data.start()].decode("latin-1")):
        words = line.split("#")[0].split()
        if words and words[0] in _KEYS:
            lines[words[0]] = words[1:]
    names = lines.get("FIELDS") or lines.get("COLUMNS") or []
    try:
        sizes = [int(n) for n in lines.get("SIZE", ["4"] * len(names))]
        counts = [int(n) for n in lines.get("COUNT", ["1"] * len(names))]
        types = lines.get("TYPE", ["F"] * len(names))
        declared = int(lines["POINTS"][0]) if lines.get("POINTS") else None
        width = int(lines["WIDTH"][0]) if lines.get("WIDTH") else declared or 0
        height = int(lines["HEIGHT"][0]) if lines.get("HEIGHT") else 1
        kinds = [_kind(t, s) for t, s in zip(types, sizes, strict=True)]
    except (ValueError, KeyError) as fault:
        raise source.error(ScanFault.MALFORMED, f"header: {fault}") from None
    _check(source, names, kinds, counts)
    if width < 0 or height < 1 or (declared is not None and declared != width * height):
        raise source.error(ScanFault.MALFORMED, f"{width} × {height} are not {declared} points")
    return _Header(names, kinds, counts, width, height, data[1].decode(), data.end())


def _kind(letter: str, size: int) -> str:
    if (letter, size) not in {("F", 4), ("F", 8), *((t, s) for t in "IU" for s in (1, 2, 4, 8))}:
        raise ValueError(f"type {letter}{size}")
    return f"<{letter.lower()}{size}"


def _check(source: Source, names: list[str], kinds: list[str], counts: list[int]) -> None:
    if not len(names) == len(kinds) == len(counts):
        raise source.error(ScanFault.MALFORMED, "FIELDS, SIZE, TYPE and COUNT do not match")
    if min(counts, default=0) < 0 or sum(counts) > _MAX_STRIDE // 8:
        raise source.error(ScanFault.MALFORMED, f"COUNT {counts[:8]}")
    for axis in "xyz":
        if axis not in names or counts[names.index(axis)] != 1:
            raise source.error(ScanFault.MALFORMED, f"no single field {axis}")


def _ascii(source: Source, header: _Header, count: int) -> NDArray[np.float64]:
    columns = np.cumsum([0, *header.counts])
    source.need(header.stop, 6 * count - 1, f"{count} points")
    used = max(int(columns[i]) for i in header.axes) + 1
    table, _ = read_table(source.array, header.stop, count, used)
    if len(table) < count:
        raise source.error(ScanFault.TRUNCATED, f"{len(table)} of {count} points can be read")
    return table[:, [int(columns[i]) for i in header.axes]]


def _columns(
    source: Source, header: _Header, count: int, start: int, data: bytes, *, packed: bool
) -> NDArray[np.float64]:
    """Columns x, y, z of binary rows, or of columns one after the other where packed."""
    offsets = header.offsets
    if count * offsets[-1] > len(data) - start:
        raise source.error(
            ScanFault.TRUNCATED, f"{count} points need {count * offsets[-1]} bytes, "
            f"{len(data) - start} are there"
        )  # fmt: skip
    out = np.empty((count, 3))
    for column, i in enumerate(header.axes):
        kind = np.dtype(header.kinds[i])
        at = start + offsets[i] * (count if packed else 1)
        stride = kind.itemsize if packed else offsets[-1]
        out[:, column] = np.ndarray((count,), kind, data, at, (stride,)) if count else 0
    return out


@njit(cache=True, nogil=True)
def _expand(packed: NDArray[np.uint8], size: int) -> NDArray[np.uint8]:
    """Undo LibLZF; shorter than `size` where the data are broken."""
    out = np.empty(size, dtype=np.uint8)
    i = o = 0
    n = len(packed)
    while i < n:
        control = int(packed[i])
        i += 1
        if control < 32:
            if i + control + 1 > n or o + control + 1 > size:
                return out[:o]
            for _ in range(control + 1):
                out[o] = packed[i]
                i += 1
                o += 1
            continue
        length = control >> 5
        if length == 7:
            if i >= n:
                return out[:o]
            length += int(packed[i])
            i += 1
        if i >= n:
            return out[:o]
        back = o - ((control & 31) << 8) - int(packed[i]) - 1
        i += 1
        if back < 0 or o + length + 2 > size:
            return out[:o]
        for k in range(length + 2):
            out[o] = out[back + k]
            o += 1
    return out[:o]
