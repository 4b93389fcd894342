"""Biwi Kinect head pose: ``.bin`` depth in runs, ``.cal`` camera, both kinds of pose file.

A depth file is little-endian: i32 width, i32 height, then runs of i32 empty pixels, i32 full
pixels and their i16 depths in mm, until the image is full. ``depth.cal`` beside it holds the
3 × 3 intrinsics first; without it the database's own values are taken.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.errors import ParameterError, ScanFault
from rangeface.io._source import Limits, Source
from rangeface.io.camera_toml import depth_image
from rangeface.numerics.text import numbers
from rangeface.types import Pinhole, RangeImage, RigidTransform

_SMALL = Limits(max_bytes=1 << 16)


def recognise(source: Source) -> bool:
    """A size, then runs that fit it; or the database's file name."""
    if len(source.data) < 16:
        return False
    width, height, empty, full = struct.unpack_from("<4i", source.data)
    if source.path.name.endswith("_depth.bin"):
        return True
    if not (8 <= width <= 4096 and 8 <= height <= 4096):
        return False
    if empty < 0 or full < 0 or empty + full > width * height:
        return False
    _, done, _ = _decode(source.array, min(width * height, source.limits.max_pixels))
    return bool(done > 0 or empty + full == width * height)


def parse(source: Source) -> RangeImage:
    """Depth image with the camera of ``depth.cal``."""
    source.need(0, 8, "the size")
    width, height = struct.unpack_from("<2i", source.data)
    source.cap_pixels(width, height)
    depth, done, whole = _decode(source.array, width * height)
    if not whole:
        raise source.error(ScanFault.TRUNCATED, f"runs give {done} of {width * height} pixels")
    return depth_image(
        source, depth.reshape(height, width), unit="mm", camera=_camera(source, width, height)
    )


def _camera(source: Source, width: int, height: int) -> Pinhole:
    beside = source.sibling(["depth.cal", source.path.stem + ".cal"])
    K = np.array([575.816, 0.0, 320.0, 0.0, 575.816, 240.0, 0.0, 0.0, 1.0])
    if beside is not None:
        K, _ = numbers(beside.array, 0, 9, commas=True)
        if len(K) < 9:
            raise beside.error(ScanFault.MALFORMED, "no 3 × 3 intrinsics")
    try:
        return Pinhole(float(K[0]), float(K[4]), float(K[2]), float(K[5]), width, height)
    except ParameterError as fault:
        raise (beside or source).error(ScanFault.BAD_CAMERA, str(fault)) from None


@njit(cache=True, nogil=True)
def _decode(data: NDArray[np.uint8], count: int) -> tuple[NDArray[np.int16], int, bool]:
    """Depths, how many pixels whole runs gave, and whether these fill the image."""
    out = np.zeros(count, dtype=np.int16)
    at, pixel = 8, 0
    while pixel < count:
        if at + 8 > len(data):
            return out, pixel, False
        run = np.zeros(2, dtype=np.int64)
        for r in range(2):
            for k in range(4):
                run[r] |= np.int64(data[at + 4 * r + k]) << (8 * k)
        at += 8
        if run[0] > count - pixel or run[1] > count - pixel - run[0]:
            return out, pixel, False
        if at + 2 * run[1] > len(data) or run[0] + run[1] == 0:
            return out, pixel, False
        pixel += run[0]
        for _ in range(run[1]):
            value = np.int32(data[at]) | (np.int32(data[at + 1]) << 8)
            out[pixel] = value - 65536 if value >= 32768 else value
            at += 2
            pixel += 1
    return out, pixel, True


def read_pose(path: str | Path) -> RigidTransform:
    """Read the head pose of a Biwi frame, in the depth camera's frame.

    Parameters
    ----------
    path : str or Path
        ``_pose.txt`` (3 × 3 rotation, then the head's centre in mm) or ``_pose.bin`` (six
        float32: the nose tip in mm, then pitch, yaw and roll in degrees).

    Returns
    -------
    RigidTransform
        T_camera_head; its translation is the point that the file states.

    Raises
    ------
    ScanError
        The file is missing, too short, or states no rotation.

    Notes
    -----
    The binary file's angles are composed as R = R_z(roll) R_y(yaw) R_x(pitch).
    """
    source = Source.open(path, _SMALL)
    if len(source.data) == 24 and source.path.suffix.lower() != ".txt":
        values = np.frombuffer(source.data, "<f4").astype(np.float64)
        rotation, translation = _euler(np.deg2rad(values[3:])), values[:3]
    else:
        values, _ = numbers(source.array, 0, 12)
        if len(values) < 12:
            raise source.error(ScanFault.TRUNCATED, f"{len(values)} of 12 numbers")
        rotation, translation = _orthonormal(values[:9].reshape(3, 3)), values[9:]
    try:
        return RigidTransform(rotation, translation, target="camera", source="head")
    except (ParameterError, np.linalg.LinAlgError) as fault:
        raise source.error(ScanFault.MALFORMED, str(fault)) from None


def _euler(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(invalid="ignore"):
        (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    return np.array(
        [
            [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx],
        ]
    )


def _orthonormal(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation closest to one that was written with few digits."""
    if not np.isfinite(R).all() or np.abs(R @ R.T - np.eye(3)).max() > 1e-2:
        return R
    U, _, Vt = np.linalg.svd(R)
    return np.asarray(U @ Vt)
