"""NumPy ``.npz``: a RangeImage as arrays, every size checked before it is expanded.

Arrays ``depth`` (H, W) in mm (or another ``depth_unit``), ``camera`` and optionally ``sigma``,
``amplitude``, ``filled``. ``camera`` is (fx, fy, cx, cy), or (pitch_mm, cx, cy) of an
orthographic image, or the 3 × 3 intrinsics (``K`` and ``intrinsics`` are
understood too); the size is the depth's. Nothing is unpickled.
"""

from __future__ import annotations

import ast
import io
import struct
import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError, ScanFault
from rangeface.io._cloud import source_unit_mm
from rangeface.io._source import Source
from rangeface.io.camera_toml import depth_image
from rangeface.types import Camera, Orthographic, Pinhole, RangeImage

_PLANES = ("sigma", "amplitude", "filled")
_CAMERAS = ("camera", "K", "intrinsics")
_NAMES = ("depth", "depth_unit", *_CAMERAS, *_PLANES)
_MAX_HEADER = 1 << 12


def recognise(source: Source) -> bool:
    """A zip archive."""
    return source.data[:4] == b"PK\x03\x04"


def parse(source: Source) -> RangeImage:
    """The image that the arrays of an archive make."""
    arrays = _arrays(source)
    if "depth" not in arrays:
        raise source.error(ScanFault.MALFORMED, f"no array 'depth' among {sorted(arrays)}")
    depth = arrays["depth"]
    if depth.ndim != 2 or depth.dtype.kind not in "uif" or not depth.size:
        raise source.error(ScanFault.WRONG_SIZE, f"depth is {depth.shape} {depth.dtype}")
    unit = "mm"
    if "depth_unit" in arrays:
        unit = str(arrays["depth_unit"].reshape(-1)[0]) if arrays["depth_unit"].size else ""
    stated = next((arrays[name] for name in _CAMERAS if name in arrays), None)
    camera = None if stated is None else _camera(source, stated, depth.shape)
    image = depth_image(source, depth, unit=unit, camera=camera)
    if isinstance(image.camera, Orthographic):  # its depth is counted from anywhere
        image = image.with_depth(_signed_depth(source, depth, unit))
    planes: dict[str, Any] = {name: arrays[name] for name in _PLANES if name in arrays}
    for name, plane in planes.items():
        if plane.shape != depth.shape or plane.dtype.kind not in "buif":
            raise source.error(
                ScanFault.WRONG_SIZE, f"{name} is {plane.shape} {plane.dtype}, depth {depth.shape}"
            )
    return RangeImage(image.depth, image.camera, **planes)


def _signed_depth(source: Source, depth: NDArray[np.generic], unit: str) -> NDArray[np.float64]:
    """Depth of an orthographic image, mm, which may be negative; NaN where invalid."""
    out = depth.astype(np.float64) * source_unit_mm(source, unit)
    out[~(np.abs(out) <= 1e6)] = np.nan
    return out


def _camera(source: Source, values: NDArray[np.generic], shape: tuple[int, ...]) -> Camera:
    if values.shape == (3, 3):
        values = values[[0, 1, 0, 1], [0, 1, 2, 2]]
    if values.shape not in ((4,), (3,)) or values.dtype.kind not in "uif":
        raise source.error(
            ScanFault.BAD_CAMERA,
            f"camera is {values.shape} {values.dtype}; (fx, fy, cx, cy) or (pitch_mm, cx, cy)",
        )
    numbers = [float(v) for v in values]
    try:
        kind = Orthographic if len(numbers) == 3 else Pinhole
        return kind(*numbers, *reversed(shape))  # type: ignore[arg-type]
    except ParameterError as fault:
        raise source.error(ScanFault.BAD_CAMERA, str(fault)) from None


def _arrays(source: Source) -> dict[str, NDArray[np.generic]]:
    try:
        archive = zipfile.ZipFile(io.BytesIO(source.data))
        entries = archive.infolist()
    except (zipfile.BadZipFile, ValueError, OSError, struct.error, NotImplementedError) as fault:
        raise source.error(ScanFault.MALFORMED, f"no zip archive: {fault}") from None
    named = {entry.filename.removesuffix(".npy"): entry for entry in entries}
    return {name: _array(source, named[name]) for name in _NAMES if name in named}


def _array(source: Source, entry: zipfile.ZipInfo) -> NDArray[np.generic]:
    """One array: the entry located by hand, so that the expansion stops at the limits."""
    start = entry.header_offset
    if start < 0:
        raise source.error(ScanFault.MALFORMED, f"entry {entry.filename} lies before the file")
    source.need(start, 30, f"entry {entry.filename}")
    magic, flags, method, name, extra = struct.unpack_from("<I2xHH16xHH", source.data, start)
    if magic != 0x04034B50 or flags & 1 or method not in (0, 8):
        raise source.error(ScanFault.MALFORMED, f"entry {entry.filename} cannot be read")
    start += 30 + name + extra
    source.need(start, entry.compress_size, f"entry {entry.filename}")
    body = source.data[start : start + entry.compress_size]
    data = source.inflate([body], -15) if method else body
    if zlib.crc32(data) != entry.CRC:
        raise source.error(ScanFault.MALFORMED, f"check sum of {entry.filename} is wrong")
    return _npy(source, data, entry.filename)


def _npy(source: Source, data: bytes, name: str) -> NDArray[np.generic]:
    """Decode the NPY format (NEP 1), without objects."""
    if data[:6] != b"\x93NUMPY" or len(data) < 12:
        raise source.error(ScanFault.MALFORMED, f"{name} is no NPY array")
    wide = data[6] >= 2
    length = struct.unpack_from("<I" if wide else "<H", data, 8)[0]
    start = (12 if wide else 10) + length
    if length > _MAX_HEADER or start > len(data):
        raise source.error(ScanFault.MALFORMED, f"{name}: header of {length} bytes")
    try:
        header = ast.literal_eval(data[start - length : start].decode("latin-1").strip())
        dtype = np.dtype(header["descr"])
        shape = tuple(int(n) for n in header["shape"])
        fortran = bool(header["fortran_order"])
    except (ValueError, TypeError, KeyError, SyntaxError, MemoryError, RecursionError) as fault:
        raise source.error(ScanFault.MALFORMED, f"{name}: header: {fault}") from None
    if dtype.kind not in "buifU" or len(shape) > 2 or min(shape, default=0) < 0:
        raise source.error(ScanFault.UNSUPPORTED, f"{name} is {shape} {dtype}")
    count = 1
    for n in shape:
        count *= n
    if len(shape) == 2 and count:
        source.cap_pixels(shape[1], shape[0])
    if dtype.itemsize > 64 or count * dtype.itemsize > len(data) - start:
        raise source.error(
            ScanFault.TRUNCATED, f"{name}: {shape} {dtype}, {len(data) - start} bytes are there"
        )
    flat = np.frombuffer(data, dtype=dtype, count=count, offset=start)
    return flat.reshape(shape, order="F" if fortran else "C")
