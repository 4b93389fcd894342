"""RAP3DF ``.data``: Kinect v2 faces of 119 × 149 px, one byte a pixel.

A byte is byte 2 of a float32: the last bit of the exponent and seven bits of the mantissa.
A depth lies between 512 and 2048 mm, so its byte v says z = 512 + 4 v mm below 128 and
z = 1024 + 8 (v − 128) mm from 128 on, to a bin of 4 or 8 mm; 0 is invalid. An infrared
amplitude has no known exponent: its byte says log2(amplitude) modulo 2 only.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._source import Source
from rangeface.numerics.unwrap import unwrap_2d
from rangeface.types import Pinhole, RangeImage

WIDTH, HEIGHT = 119, 149

#: Nominal intrinsics of a Kinect v2 in the crop at column 197, row 138 of 512 × 424.
CAMERA = Pinhole(fx=365.5, fy=365.5, cx=59.0, cy=68.0, width=WIDTH, height=HEIGHT)

#: Standard deviation of a Kinect v2 depth below 1.5 m before quantisation, mm (Fankhauser et
#: al. 2015, doi:10.1109/ICAR.2015.7251485, give 1 to 2 mm on a frontal surface).
SENSOR_SIGMA_MM = 1.5

#: The amplitude's absolute scale is unknown: its median is set to this.
MEDIAN_AMPLITUDE = 1000.0


def recognise(source: Source) -> bool:
    """119 × 149 uint16 whose high bytes are all zero."""
    return len(source.data) == 2 * WIDTH * HEIGHT and not any(source.data[1::2])


def parse(source: Source) -> RangeImage:
    """Depth at the bins' centres, σ of bin and sensor together, amplitude if a file has it."""
    if "_ir." in source.path.name:
        raise source.error(ScanFault.UNSUPPORTED, "infrared plane; give the depth file beside it")
    byte = source.array[::2].reshape(HEIGHT, WIDTH).astype(np.float32)
    near = byte < 128
    bin_mm = np.where(near, 4.0, 8.0)
    start_mm = np.where(near, 512.0 + 4.0 * byte, 1024.0 + 8.0 * (byte - 128.0))
    depth = np.where(byte > 0, start_mm + bin_mm / 2, np.nan)
    sigma = np.sqrt(bin_mm**2 / 12.0 + SENSOR_SIGMA_MM**2)
    camera = source.camera or CAMERA
    if (camera.width, camera.height) != (WIDTH, HEIGHT):
        raise source.error(
            ScanFault.WRONG_SIZE,
            f"camera of {camera.width} × {camera.height} px for an image of {WIDTH} × {HEIGHT}",
        )
    return RangeImage(depth, camera, sigma=sigma, amplitude=_amplitude(source, depth))


def _amplitude(source: Source, depth: NDArray[np.floating]) -> NDArray[np.float32] | None:
    """Amplitude up to one factor, from the infrared file that belongs to a depth file."""
    stem = source.path.name.removesuffix("depth.data")
    if stem == source.path.name:
        return None
    bodies = (stem, stem.replace("_xyz_", "_xy_"), stem.replace("_xy_", "_xyz_"))
    found = source.sibling([b + end for end in ("ir.data", "ir_view.bmp") for b in bodies])
    if found is None:
        return None
    byte = _bitmap_red(found) if found.data[:2] == b"BM" else _infrared(found)
    mantissa = 1.0 + ((byte & 127) + 0.5) / 128.0
    log2 = np.log2(mantissa) + (byte >= 128)
    log2 = unwrap_2d(np.where(np.isfinite(depth), log2, np.nan), period=2.0)
    if not np.isfinite(log2).any():
        return None
    relative = np.exp2(np.clip(log2 - np.nanmedian(log2), -30, 30))
    return (MEDIAN_AMPLITUDE * relative).astype(np.float32)


def _infrared(source: Source) -> NDArray[np.uint8]:
    source.need(0, 2 * WIDTH * HEIGHT, "an infrared plane")
    return source.array[: 2 * WIDTH * HEIGHT : 2].reshape(HEIGHT, WIDTH)


def _bitmap_red(source: Source) -> NDArray[np.uint8]:
    """Red plane of an uncompressed 24-bit bitmap of the right size, top row first."""
    source.need(0, 54, "a bitmap header")
    offset, width, height, bits, packing = struct.unpack("<10xI4xii2xHI", source.data[:34])
    if (width, abs(height), bits, packing) != (WIDTH, HEIGHT, 24, 0):
        raise source.error(
            ScanFault.WRONG_SIZE, f"infrared bitmap of {width} × {height} px, {bits} bits"
        )
    stride = (3 * WIDTH + 3) // 4 * 4
    source.need(offset, stride * HEIGHT, "an infrared bitmap")
    rows = source.array[offset : offset + stride * HEIGHT].reshape(HEIGHT, stride)
    red = rows[:, 2 : 3 * WIDTH : 3]
    return red[::-1] if height > 0 else red
