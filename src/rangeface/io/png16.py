"""16-bit greyscale PNG (ISO/IEC 15948), read and written without a foreign library.

Other depths and colours hold no depth and are refused. The unit and the camera come from the
caller or a camera file (see `camera_toml`).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io import truedepth
from rangeface.io._source import Source
from rangeface.io.camera_toml import depth_image
from rangeface.types import RangeImage

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def recognise(source: Source) -> bool:
    """The eight bytes that open every PNG."""
    return source.data.startswith(SIGNATURE)


def parse(source: Source) -> RangeImage:
    """Depth image of a PNG, with its camera file or TrueDepth's JSON."""
    raw = pixels(source)
    height, width = raw.shape
    if source.sibling([source.path.stem + ".toml", "camera.toml"]) is None:
        camera = truedepth.intrinsics(source, width, height)
        if camera is not None:
            return depth_image(source, raw, unit=truedepth.UNIT, camera=camera)
    return depth_image(source, raw)


def pixels(source: Source) -> NDArray[np.uint16]:
    """The pixels of a 16-bit greyscale PNG, (H, W) uint16."""
    width = height = 0
    packed: list[bytes] = []
    for kind, body in _chunks(source):
        if kind == b"IHDR":
            width, height = _header(source, body)
        elif not width:
            raise source.error(ScanFault.MALFORMED, "the header is not the first chunk")
        elif kind == b"IDAT":
            packed.append(body)
    if not width:
        raise source.error(ScanFault.MALFORMED, "no header")
    stride = 1 + 2 * width
    rows = np.frombuffer(source.inflate(packed, 15, stride * height), dtype=np.uint8)
    rows = rows.reshape(height, stride)
    if rows[:, 0].max() > 4:
        raise source.error(ScanFault.MALFORMED, f"unknown row filter {rows[:, 0].max()}")
    return _unfilter(rows).view(">u2").astype(np.uint16)


def _chunks(source: Source) -> Iterator[tuple[bytes, bytes]]:
    offset = len(SIGNATURE)
    if not recognise(source):
        raise source.error(ScanFault.MALFORMED, "no PNG")
    while True:
        source.need(offset, 12, "a chunk")
        length, kind = struct.unpack_from(">I4s", source.data, offset)
        source.need(offset, 12 + length, f"chunk {kind!r}")
        body = source.data[offset + 8 : offset + 8 + length]
        (check,) = struct.unpack_from(">I", source.data, offset + 8 + length)
        if check != zlib.crc32(body, zlib.crc32(kind)):
            raise source.error(ScanFault.MALFORMED, f"check sum of chunk {kind!r} is wrong")
        if kind == b"IEND":
            return
        yield kind, body
        offset += 12 + length


def _header(source: Source, body: bytes) -> tuple[int, int]:
    if len(body) != 13:
        raise source.error(ScanFault.MALFORMED, f"header of {len(body)} bytes")
    width, height, bits, colour, packing, filters, interlace = struct.unpack(">IIBBBBB", body)
    source.cap_pixels(width, height)
    if (bits, colour) != (16, 0):
        raise source.error(
            ScanFault.UNSUPPORTED, f"{bits} bits, colour type {colour}; depth is 16-bit grey"
        )
    if packing or filters or interlace:
        raise source.error(ScanFault.UNSUPPORTED, "interlaced or unknown packing")
    return width, height


@njit(cache=True, nogil=True)
def _unfilter(rows: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Undo the row filters (ISO/IEC 15948, 9.2) for two bytes a pixel."""
    height, width = rows.shape[0], rows.shape[1] - 1
    out = np.zeros((height, width), dtype=np.uint8)
    for r in range(height):
        kind = rows[r, 0]
        for i in range(width):
            left = np.int32(out[r, i - 2]) if i >= 2 else np.int32(0)
            above = np.int32(out[r - 1, i]) if r else np.int32(0)
            if kind == 0:
                guess = np.int32(0)
            elif kind == 1:
                guess = left
            elif kind == 2:
                guess = above
            elif kind == 3:
                guess = (left + above) // 2
            else:
                corner = np.int32(out[r - 1, i - 2]) if r and i >= 2 else np.int32(0)
                p = left + above - corner
                a, b, c = abs(p - left), abs(p - above), abs(p - corner)
                guess = left if a <= b and a <= c else (above if b <= c else corner)
            out[r, i] = (np.int32(rows[r, i + 1]) + guess) & 255
    return out


def encode(image: NDArray[np.uint16]) -> bytes:
    """The bytes of a 16-bit greyscale PNG (each row filtered by the one above it)."""
    height, width = image.shape
    raw = np.ascontiguousarray(image, dtype=">u2").view(np.uint8).reshape(height, 2 * width)
    up = raw.copy()
    up[1:] -= raw[:-1]
    rows = np.concatenate([np.full((height, 1), 2, np.uint8), up], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return SIGNATURE + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in (
            (b"IHDR", header),
            (b"IDAT", zlib.compress(rows.tobytes(), 6)),
            (b"IEND", b""),
        )
    )
