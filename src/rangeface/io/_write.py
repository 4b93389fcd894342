"""Range images and points → files."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from rangeface.errors import ParameterError
from rangeface.io import png16
from rangeface.io._mcap_writer import encode
from rangeface.numerics.polygons import grid_triangles
from rangeface.types import Camera, Orthographic, PointSet, RangeImage

_JUMP_MM = 12.0


def write_scan(path: str | Path, image: RangeImage) -> None:
    """Write a range image in the format that the file's ending names.

    Parameters
    ----------
    path : str or Path
        Ends in ``.npz`` (everything, exactly), ``.png`` (16 bits, with a camera TOML beside
        it; the depth step is the smallest of 0.01, 0.02, 0.05, 0.1, … mm that fits),
        ``.ply`` (a mesh in the camera's frame, y up, z towards the viewer) or ``.mcap`` (one
        ROS 2 message). The file appears whole or not at all.
    image : RangeImage
        The image.

    Raises
    ------
    ParameterError
        The ending is unknown, or the format cannot hold this image.

    Examples
    --------
    >>> import tempfile
    >>> from rangeface import Pinhole, RangeImage
    >>> from rangeface.io import read_scan
    >>> path = Path(tempfile.mkdtemp()) / "one.png"
    >>> write_scan(path, RangeImage([[400.0, 500.0]], Pinhole(200, 200, 0.5, 0, 2, 1)))
    >>> read_scan(path).depth
    array([[400., 500.]], dtype=float32)
    """
    path = Path(path)
    if path.suffix.lower() not in WRITERS:
        raise ParameterError(f"path: ending {path.suffix!r}, not one of {', '.join(WRITERS)}")
    WRITERS[path.suffix.lower()](path, image)


def write_points(path: str | Path, points: PointSet) -> None:
    """Write points, and triangles if there are any, as binary PLY.

    Parameters
    ----------
    path : str or Path
        Ends in ``.ply``.
    points : PointSet
        In the camera's axes; written with y up and z towards the viewer, mm.

    Raises
    ------
    ParameterError
        The ending is another.
    """
    path = Path(path)
    if path.suffix.lower() != ".ply":
        raise ParameterError(f"path: points are written as .ply, not {path.suffix!r}")
    _replace(path, _ply(points))


def _write_ply(path: Path, image: RangeImage) -> None:
    points = image.points.reshape(-1, 3)
    valid = np.isfinite(points).all(axis=1)
    number = np.cumsum(valid) - 1
    triangles = number[grid_triangles(image.points, _JUMP_MM)]
    _replace(path, _ply(PointSet(points[valid], triangles.astype(np.int32))))


def _write_png(path: Path, image: RangeImage) -> None:
    if not (image.depth[image.mask] > 0).all():
        raise ParameterError("image: a PNG holds no depth ≤ 0; write an .npz")
    farthest = float(np.nanmax(image.depth, initial=0.0))
    steps = (d * 10.0**e for e in range(-2, 4) for d in (1, 2, 5))
    step = next((s for s in steps if farthest / s <= 65533), None)
    if step is None:
        raise ParameterError(f"image: {farthest:.0f} mm is too far for a PNG")
    pixels = np.where(image.mask, np.rint(np.nan_to_num(image.depth) / step), 0)
    toml = camera_toml_text(image.camera) + f"depth_scale_mm = {step:g}\n"
    _replace(path.with_suffix(".toml"), toml.encode())
    _replace(path, png16.encode(np.maximum(pixels, image.mask).astype(np.uint16)))


def camera_toml_text(camera: Camera) -> str:
    """A camera as the lines of a camera TOML."""
    names = ["width", "height", "cx", "cy"]
    names[:0] = ["pitch_mm"] if isinstance(camera, Orthographic) else ["fx", "fy"]
    return "".join(f"{name} = {getattr(camera, name)!r}\n" for name in names)


def _write_npz(path: Path, image: RangeImage) -> None:
    c = image.camera
    values = (c.pitch_mm, c.cx, c.cy) if isinstance(c, Orthographic) else (c.fx, c.fy, c.cx, c.cy)
    arrays: dict[str, Any] = {"depth": image.depth, "camera": np.array(values, np.float64)}
    for name in ("sigma", "amplitude", "filled"):
        if getattr(image, name) is not None:
            arrays[name] = getattr(image, name)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    _replace(path, buffer.getvalue())


def _write_mcap(path: Path, image: RangeImage) -> None:
    _replace(path, encode([image]))


def write_frames(path: str | Path, frames: list[RangeImage], *, rate_hz: float = 30.0) -> None:
    """Write a recording of range images as MCAP (ROS 2 messages, 32FC1 in metres).

    Parameters
    ----------
    path : str or Path
        Ends in ``.mcap``.
    frames : list of RangeImage
        With pinhole cameras, in their order.
    rate_hz : float
        Frames a second, > 0.

    Raises
    ------
    ParameterError
        The ending is another, the rate is not > 0, or a camera is no pinhole.
    """
    path = Path(path)
    if path.suffix.lower() != ".mcap":
        raise ParameterError(f"path: recordings are written as .mcap, not {path.suffix!r}")
    if not (np.isfinite(rate_hz) and rate_hz > 0):
        raise ParameterError(f"rate_hz must be > 0, got {rate_hz}")
    _replace(path, encode(list(frames), rate_hz=rate_hz))


def _ply(cloud: PointSet) -> bytes:
    lines = ["ply", "format binary_little_endian 1.0", "comment mm, y up, z towards the viewer"]
    lines += [f"element vertex {len(cloud.points)}", *(f"property float {a}" for a in "xyz")]
    body = (cloud.points * np.array([1, -1, -1], np.float32)).astype("<f4").tobytes()
    if cloud.triangles is not None:
        lines += [f"element face {len(cloud.triangles)}", "property list uchar int vertex_indices"]
        rows = np.empty(len(cloud.triangles), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
        rows["n"], rows["i"] = 3, cloud.triangles
        body += rows.tobytes()
    return "\n".join([*lines, "end_header\n"]).encode() + body


def _replace(path: Path, data: bytes) -> None:
    """Write beside the file and rename, so that no half file is ever seen."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        beside.write_bytes(data)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


#: Ending of a file → its writer.
WRITERS: dict[str, Callable[[Path, RangeImage], None]] = {
    ".npz": _write_npz,
    ".png": _write_png,
    ".ply": _write_ply,
    ".mcap": _write_mcap,
}
