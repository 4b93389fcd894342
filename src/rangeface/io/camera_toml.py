"""Camera files: the intrinsics and the depth unit of an image, in TOML.

::

    width = 640         # px
    height = 480        # px
    fx = 594.2          # px
    fy = 591.0          # px
    cx = 339.3          # px, the centre of the first pixel is 0
    cy = 242.7          # px
    depth_unit = "mm"   # "um", "0.1mm", "mm", "cm", "m"; or depth_scale_mm = 0.125

It stands beside the image as ``<image>.toml``, or as ``camera.toml`` in the image's folder or
one of the three above it. An orthographic image has
``pitch_mm`` in place of fx and fy. A length may carry its unit in its name (``fx_px``), and
everything may stand in a table ``[camera]``.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError, ScanFault, UnitError
from rangeface.io._cloud import source_unit_mm, unit_mm
from rangeface.io._source import Limits, Source
from rangeface.types import Camera, Orthographic, Pinhole, RangeImage

_MAX_BYTES = 1 << 16
_LENGTHS = ("fx", "fy", "cx", "cy", "width", "height")
_KEYS = (*_LENGTHS, "pitch_mm", "depth_unit", "depth_scale_mm")
_TEXT = ("sensor", "note", "model", "name")


@dataclass(frozen=True)
class CameraFile:
    """What a camera file says.

    Parameters
    ----------
    camera : Pinhole or Orthographic
        Intrinsics.
    scale_mm : float, optional
        Millimetres in one unit of depth; None where the file does not say.
    """

    camera: Camera
    scale_mm: float | None = None


def read_camera(path: str | Path) -> CameraFile:
    """Read a camera TOML.

    Parameters
    ----------
    path : str or Path
        The file; its keys are listed above.

    Returns
    -------
    CameraFile
        The camera, and the depth scale if it is stated.

    Raises
    ------
    ScanError
        The file is missing or no TOML, a key is unknown, missing or no number, the camera is
        impossible, or the unit is unknown.
    """
    return _camera_file(Source.open(path, Limits(max_bytes=_MAX_BYTES)))


def _camera_file(source: Source) -> CameraFile:
    try:
        table = tomllib.loads(source.data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as fault:
        raise source.error(ScanFault.MALFORMED, f"no TOML: {fault}") from None
    table = table.get("camera", table)
    if not isinstance(table, dict):
        raise source.error(ScanFault.BAD_CAMERA, "camera is no table")
    keys = {name.removesuffix("_px"): value for name, value in table.items()}
    unknown = sorted(set(keys) - set(_KEYS) - set(_TEXT))
    if unknown:
        raise source.error(
            ScanFault.BAD_CAMERA, f"unknown key {unknown[0]!r}; known: {', '.join(_KEYS)}"
        )
    return CameraFile(_camera(source, keys), _scale_mm(source, keys))


def _camera(source: Source, keys: dict[str, Any]) -> Camera:
    names = ("pitch_mm", *_LENGTHS[2:]) if "pitch_mm" in keys else _LENGTHS
    for name in names:
        if name not in keys:
            raise source.error(ScanFault.BAD_CAMERA, f"key {name!r} is missing")
        if isinstance(keys[name], bool) or not isinstance(keys[name], int | float):
            raise source.error(ScanFault.BAD_CAMERA, f"{name} must be a number: {keys[name]!r}")
        if abs(keys[name]) >= 1e15:  # TOML's whole numbers have no bound
            raise source.error(ScanFault.BAD_CAMERA, f"{name} is out of bounds")
    for name in ("width", "height"):
        if not (np.isfinite(keys[name]) and keys[name] == int(keys[name])):
            raise source.error(ScanFault.BAD_CAMERA, f"{name} must be whole: {keys[name]!r}")
    values = {name: float(keys[name]) for name in names[:-2]}
    size = (int(keys["width"]), int(keys["height"]))
    try:
        if "pitch_mm" in keys:
            return Orthographic(values["pitch_mm"], values["cx"], values["cy"], *size)
        return Pinhole(values["fx"], values["fy"], values["cx"], values["cy"], *size)
    except ParameterError as fault:
        raise source.error(ScanFault.BAD_CAMERA, str(fault)) from None


def _scale_mm(source: Source, keys: dict[str, Any]) -> float | None:
    if "depth_unit" in keys and "depth_scale_mm" in keys:
        raise source.error(ScanFault.UNKNOWN_UNIT, "both depth_unit and depth_scale_mm are given")
    if "depth_unit" in keys:
        try:
            return unit_mm(keys["depth_unit"])
        except UnitError as fault:
            raise source.error(ScanFault.UNKNOWN_UNIT, f"depth_unit: {fault}") from None
    scale = keys.get("depth_scale_mm")
    if scale is None:
        return None
    if isinstance(scale, bool) or not isinstance(scale, int | float) or not 0 < scale < 1e6:
        raise source.error(ScanFault.UNKNOWN_UNIT, f"depth_scale_mm must be > 0: {scale!r}")
    return float(scale)


def _check_sane(source: Source, camera: Camera) -> None:
    """Refuse a camera that no optics have: its points would overflow."""
    sizes = (
        {"pitch_mm": camera.pitch_mm}
        if isinstance(camera, Orthographic)
        else {"fx": camera.fx, "fy": camera.fy}
    )
    for name, value in sizes.items():
        if not 1e-3 <= value <= 1e6:
            raise source.error(ScanFault.BAD_CAMERA, f"{name} = {value:.3g} is out of bounds")
    for name in ("cx", "cy"):
        if not abs(getattr(camera, name)) <= 1e6:
            raise source.error(
                ScanFault.BAD_CAMERA, f"{name} = {getattr(camera, name):.3g} is out of bounds"
            )


def depth_image(
    source: Source, raw: NDArray[Any], *, unit: str | None = None, camera: Camera | None = None
) -> RangeImage:
    """A depth plane with the camera and the unit that the caller, a camera file or the format has.

    Zero, negative, non-finite and, in 16-bit images, 65535 are invalid.
    """
    height, width = raw.shape
    stated = source.camera or camera
    scale = None
    beside = None
    if stated is None or (source.unit or unit) is None:
        above = ["../" * level + "camera.toml" for level in range(4)]
        beside = source.sibling([source.path.stem + ".toml", *above])
    if beside is not None:
        found = _camera_file(beside)
        stated = stated or found.camera
        scale = found.scale_mm
    if stated is None:
        raise source.error(
            ScanFault.BAD_CAMERA,
            f"no camera known: put {source.path.stem}.toml or camera.toml beside it",
        )
    _check_sane(source, stated)
    if (stated.width, stated.height) != (width, height):
        raise source.error(
            ScanFault.WRONG_SIZE,
            f"camera of {stated.width} × {stated.height} px, image of {width} × {height} px",
        )
    if source.unit is not None or scale is None:
        scale = source_unit_mm(source, unit)
    with np.errstate(over="ignore", invalid="ignore"):  # signalling NaN, values near the largest
        depth = raw.astype(np.float64) * scale
    valid = (depth > 0) & (depth <= 1e6)
    if raw.dtype == np.uint16:
        valid &= raw < 65535
    return RangeImage(np.where(valid, depth, np.nan), stated)
