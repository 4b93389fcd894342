"""TIFF 6.0 with one plane of depth: 16- or 32-bit integers or floats.

Strips and tiles, both byte orders, no compression, LZW, Deflate and PackBits, horizontal and
floating-point prediction. The unit and the camera come from the caller or a camera file.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._source import Source
from rangeface.io.camera_toml import depth_image
from rangeface.types import RangeImage

_WIDTH, _HEIGHT, _BITS, _PACKING, _PHOTOMETRIC = 256, 257, 258, 259, 262
_STRIPS, _SAMPLES, _ROWS, _COUNTS, _PREDICTOR = 273, 277, 278, 279, 317
_TILE_WIDTH, _TILE_HEIGHT, _TILES, _TILE_COUNTS, _SAMPLE_FORMAT = 322, 323, 324, 325, 339
_TYPES = {1: "u1", 3: "u2", 4: "u4", 6: "i1", 8: "i2", 9: "i4", 16: "u8"}
_MAX_TAGS = 256


@dataclass
class _Layout:
    width: int
    height: int
    dtype: np.dtype[np.generic]
    packing: int
    predictor: int
    block: tuple[int, int]  # rows and columns of a strip or tile
    offsets: list[int]
    counts: list[int]


def recognise(source: Source) -> bool:
    """The byte order twice, then 42."""
    return source.data[:4] in (b"II*\0", b"MM\0*")


def parse(source: Source) -> RangeImage:
    """Depth image of the first page, with its camera file."""
    return depth_image(source, pixels(source))


def pixels(source: Source) -> NDArray[np.generic]:
    """The pixels of the first page, (H, W)."""
    layout = _layout(source)
    rows, columns = layout.block
    across = -(-layout.width // columns)
    out = np.zeros((layout.height, layout.width), dtype=layout.dtype.newbyteorder("="))
    for number, (offset, count) in enumerate(zip(layout.offsets, layout.counts, strict=True)):
        top, left = number // across * rows, number % across * columns
        tall = rows if columns != layout.width else min(rows, layout.height - top)
        source.need(offset, count, f"strip {number}")
        raw = _unpack(source, layout, offset, count, tall * columns * layout.dtype.itemsize)
        block = _unpredict(raw, layout, tall, columns)
        out[top : top + tall, left : left + columns] = block[
            : layout.height - top, : layout.width - left
        ]
    return out


def _layout(source: Source) -> _Layout:
    order = "<" if source.data[:2] == b"II" else ">"
    tags = _tags(source, order)

    def one(tag: int, default: int | None = None) -> int:
        if tag not in tags:
            if default is None:
                raise source.error(ScanFault.MALFORMED, f"tag {tag} is missing")
            return default
        return tags[tag][0]

    width, height = one(_WIDTH), one(_HEIGHT)
    source.cap_pixels(width, height)
    kind = {1: "u", 2: "i", 3: "f"}.get(one(_SAMPLE_FORMAT, 1), "")
    bits = one(_BITS, 1)
    if one(_SAMPLES, 1) != 1 or (kind, bits) not in {
        ("u", 16), ("i", 16), ("u", 32), ("i", 32), ("f", 32), ("f", 64),
    }:  # fmt: skip
        raise source.error(
            ScanFault.UNSUPPORTED, f"{one(_SAMPLES, 1)} samples of {bits} bits; depth has one of 16"
        )
    tiled = _TILES in tags
    if tiled:
        block = (one(_TILE_HEIGHT), one(_TILE_WIDTH))
    else:
        block = (min(one(_ROWS, height), height), width)
    offsets = tags.get(_TILES if tiled else _STRIPS, [])
    counts = tags.get(_TILE_COUNTS if tiled else _COUNTS, [])
    source.cap_pixels(block[1], block[0])
    blocks = -(-height // block[0]) * -(-width // block[1])
    if not counts and len(offsets) == 1 and one(_PACKING, 1) == 1:
        counts = [width * height * bits // 8]  # old writers leave it out
    if len(offsets) != blocks or len(counts) != blocks:
        raise source.error(
            ScanFault.MALFORMED, f"{len(offsets)} offsets, {len(counts)} sizes, {blocks} strips"
        )
    if blocks * block[0] * block[1] > 4 * source.limits.max_pixels:
        raise source.error(ScanFault.TOO_LARGE, f"{blocks} tiles of {block[1]} × {block[0]} px")
    dtype = np.dtype(f"{order}{kind}{bits // 8}")
    return _Layout(
        width, height, dtype, one(_PACKING, 1), one(_PREDICTOR, 1), block, offsets, counts
    )


def _tags(source: Source, order: str) -> dict[int, list[int]]:
    source.need(0, 8, "the header")
    (start,) = struct.unpack_from(order + "I", source.data, 4)
    source.need(start, 2, "the directory")
    (count,) = struct.unpack_from(order + "H", source.data, start)
    if count > _MAX_TAGS:
        raise source.error(ScanFault.TOO_LARGE, f"{count} tags")
    source.need(start + 2, 12 * count, f"{count} tags")
    tags: dict[int, list[int]] = {}
    for k in range(count):
        at = start + 2 + 12 * k
        tag, kind, number = struct.unpack_from(order + "HHI", source.data, at)
        if kind not in _TYPES or number == 0:
            continue
        dtype = np.dtype(order + _TYPES[kind])
        where = at + 8
        if number * dtype.itemsize > 4:
            (where,) = struct.unpack_from(order + "I", source.data, at + 8)
        if tag in (_STRIPS, _COUNTS, _TILES, _TILE_COUNTS) or number <= 16:
            source.need(where, number * dtype.itemsize, f"tag {tag}")
            tags[tag] = np.frombuffer(source.data, dtype, number, where).tolist()
    return tags


def _unpack(source: Source, layout: _Layout, offset: int, count: int, size: int) -> bytes:
    packed = source.data[offset : offset + count]
    if layout.packing == 1:
        raw = packed[:size]
    elif layout.packing in (8, 32946):
        raw = source.inflate([packed], 15, size)
    elif layout.packing in (5, 32773):
        if size > source.limits.expanded(count):
            raise source.error(ScanFault.TOO_LARGE, f"{count} bytes expand to {size}")
        decode = _lzw if layout.packing == 5 else _packbits
        raw = decode(np.frombuffer(packed, np.uint8), size).tobytes()
    else:
        raise source.error(ScanFault.UNSUPPORTED, f"compression {layout.packing}")
    if len(raw) < size:
        raise source.error(ScanFault.TRUNCATED, f"a strip has {len(raw)} of {size} bytes")
    return raw


def _unpredict(raw: bytes, layout: _Layout, rows: int, columns: int) -> NDArray[np.generic]:
    if layout.predictor == 3 and layout.dtype.kind == "f":
        size = layout.dtype.itemsize  # bytes of a row: all first bytes, all second bytes, …
        planes = np.cumsum(
            np.frombuffer(raw, np.uint8).reshape(rows, columns * size), axis=1, dtype=np.uint8
        )
        mixed = planes.reshape(rows, size, columns).transpose(0, 2, 1)
        return np.ascontiguousarray(mixed).view(f">f{size}")[..., 0]
    block = np.frombuffer(raw, layout.dtype).reshape(rows, columns)
    if layout.predictor == 2 and layout.dtype.kind in "ui":
        native = block.astype(layout.dtype.newbyteorder("="))
        return np.cumsum(native, axis=1, dtype=native.dtype)
    return block


@njit(cache=True, nogil=True)
def _packbits(packed: NDArray[np.uint8], size: int) -> NDArray[np.uint8]:
    """Undo PackBits; shorter than `size` where the data are broken."""
    out = np.empty(size, dtype=np.uint8)
    i = o = 0
    while i + 1 < len(packed) and o < size:
        control = np.int64(packed[i])
        i += 1
        if control < 128:
            for _ in range(min(int(control) + 1, len(packed) - i, size - o)):
                out[o] = packed[i]
                i += 1
                o += 1
        elif control > 128:
            for _ in range(min(257 - int(control), size - o)):
                out[o] = packed[i]
                o += 1
            i += 1
    return out[:o]


@njit(cache=True, nogil=True)
def _lzw(packed: NDArray[np.uint8], size: int) -> NDArray[np.uint8]:
    """Undo TIFF's LZW (TIFF 6.0, section 13); shorter than `size` where the data are broken."""
    out = np.empty(size, dtype=np.uint8)
    start = np.zeros(4097, dtype=np.int64)  # an entry is a piece of the output
    length = np.zeros(4097, dtype=np.int64)
    bits, width, at, o = np.int64(0), 0, 0, 0
    code_width, following, previous = 9, 258, -1
    while o < size:
        while width < code_width:
            if at >= len(packed):
                return out[:o]
            bits = ((bits << 8) | packed[at]) & 0xFFFFFF
            width += 8
            at += 1
        code = (bits >> (width - code_width)) & ((1 << code_width) - 1)
        width -= code_width
        if code == 257:
            return out[:o]
        if code == 256:
            code_width, following, previous = 9, 258, -1
            continue
        begin = o
        if code < 256:
            out[o] = code
            o += 1
        elif code < following or (code == following and previous >= 0):
            source, count = start[code], length[code]
            if code == following:  # the entry that is being made: the last piece and its head
                source, count = previous, begin - previous + 1
            for k in range(min(count, size - o)):
                out[o] = out[source + k]
                o += 1
        else:
            return out[:o]
        if previous >= 0 and following < 4096:
            start[following], length[following] = previous, begin - previous + 1
            following += 1
        previous = begin
        if following >= 511 and following >= (1 << code_width) - 1 and code_width < 12:
            code_width += 1
    return out
