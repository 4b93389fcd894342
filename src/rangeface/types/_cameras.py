"""Pinhole and parallel projection."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from rangeface.errors import ParameterError
from rangeface.numerics.projection import Projection
from rangeface.types._arrays import Float32, Float64


@dataclass(frozen=True)
class Pinhole:
    """A pinhole camera without distortion.

    Parameters
    ----------
    fx, fy : float
        Focal lengths, px, > 0.
    cx, cy : float
        Principal point, px; the centre of the first pixel is (0, 0).
    width, height : int
        Size of the image, px, ≥ 1.

    Raises
    ------
    ParameterError
        A focal length is not positive and finite, a principal point is not finite, a size < 1.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    def __post_init__(self) -> None:
        for name in ("fx", "fy"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise ParameterError(
                    f"{name}: focal length must be > 0 px, got {getattr(self, name)}"
                )
        _check_grid(self)

    def back_project(self, depth: ArrayLike) -> Float32:
        """Points of a depth image: (H, W) mm → (H, W, 3) mm, NaN where depth is."""
        z = np.asarray(depth, dtype=np.float32)
        u = ((np.arange(self.width) - self.cx) / self.fx).astype(np.float32)
        v = ((np.arange(self.height) - self.cy) / self.fy).astype(np.float32)
        return np.stack([z * u[None, :], z * v[:, None], z], axis=-1)

    def project(self, points: ArrayLike) -> Float64:
        """Pixel coordinates (…, 2) of points (…, 3) mm in the camera frame; NaN behind it."""
        p = np.asarray(points, dtype=np.float64)
        z = np.where(p[..., 2] > 0, p[..., 2], np.nan)
        return np.stack(
            [p[..., 0] / z * self.fx + self.cx, p[..., 1] / z * self.fy + self.cy], axis=-1
        )

    def radial_factor(self) -> Float32:
        """Radial range over depth, (H, W): the length of each pixel's ray at z = 1."""
        u = (np.arange(self.width) - self.cx) / self.fx
        v = (np.arange(self.height) - self.cy) / self.fy
        return np.sqrt(1.0 + u[None, :] ** 2 + v[:, None] ** 2).astype(np.float32)

    def pixel_mm(self, depth_mm: float) -> float:
        """Width of a pixel's footprint, mm, on a frontal surface at the given depth."""
        return float(depth_mm / np.sqrt(self.fx * self.fy))

    @property
    def projection(self) -> Projection:
        """The camera's parameters as the kernels take them."""
        return Projection(True, self.fx, self.fy, self.cx, self.cy)

    def crop(self, left: int, top: int, width: int, height: int) -> Pinhole:
        """The camera of the window whose first pixel is (left, top)."""
        return Pinhole(self.fx, self.fy, self.cx - left, self.cy - top, width, height)


@dataclass(frozen=True)
class Orthographic:
    """A parallel projection: every pixel is a square of `pitch_mm` at any depth.

    Parameters
    ----------
    pitch_mm : float
        Edge of a pixel, mm, > 0.
    cx, cy : float
        Pixel coordinates of the axis x = y = 0.
    width, height : int
        Size of the image, px, ≥ 1.

    Raises
    ------
    ParameterError
        The pitch is not positive and finite, a principal point is not finite, a size < 1.
    """

    pitch_mm: float
    cx: float
    cy: float
    width: int
    height: int

    def __post_init__(self) -> None:
        if not (np.isfinite(self.pitch_mm) and self.pitch_mm > 0):
            raise ParameterError(f"pitch_mm must be > 0, got {self.pitch_mm}")
        _check_grid(self)

    @classmethod
    def centred(cls, width_mm: float, height_mm: float, width: int, height: int) -> Orthographic:
        """The camera of `width` × `height` pixels over the given extent, its axis at the centre.

        Raises
        ------
        ParameterError
            The pitches in x and y differ by more than 1 %.
        """
        pitch_x, pitch_y = width_mm / width, height_mm / height
        if not abs(pitch_x - pitch_y) <= 0.01 * pitch_x:
            raise ParameterError(
                f"width_mm, height_mm: {pitch_x:.3g} and {pitch_y:.3g} mm a pixel differ; "
                "choose an extent with square pixels"
            )
        return cls(pitch_x, (width - 1) / 2, (height - 1) / 2, width, height)

    def back_project(self, depth: ArrayLike) -> Float32:
        """Points of a depth image: (H, W) mm → (H, W, 3) mm, NaN where depth is."""
        z = np.asarray(depth, dtype=np.float32)
        u = ((np.arange(self.width) - self.cx) * self.pitch_mm).astype(np.float32)
        v = ((np.arange(self.height) - self.cy) * self.pitch_mm).astype(np.float32)
        hole = z * 0.0  # NaN where depth is, so that a hole has no x and y either
        return np.stack([hole + u[None, :], hole + v[:, None], z], axis=-1)

    def project(self, points: ArrayLike) -> Float64:
        """Pixel coordinates (…, 2) of points (…, 3) mm in the camera frame."""
        p = np.asarray(points, dtype=np.float64)
        return p[..., :2] / self.pitch_mm + np.array([self.cx, self.cy])

    def radial_factor(self) -> Float32:
        """Ones (H, W): along parallel rays range is depth."""
        return np.ones((self.height, self.width), dtype=np.float32)

    def pixel_mm(self, depth_mm: float) -> float:
        """Width of a pixel's footprint, mm: the pitch at every depth."""
        return float(self.pitch_mm)

    @property
    def projection(self) -> Projection:
        """The camera's parameters as the kernels take them."""
        return Projection(False, 1.0 / self.pitch_mm, 1.0 / self.pitch_mm, self.cx, self.cy)

    def crop(self, left: int, top: int, width: int, height: int) -> Orthographic:
        """The camera of the window whose first pixel is (left, top)."""
        return Orthographic(self.pitch_mm, self.cx - left, self.cy - top, width, height)


Camera: TypeAlias = Pinhole | Orthographic


def _check_grid(camera: Camera) -> None:
    for name in ("cx", "cy"):
        if not np.isfinite(getattr(camera, name)):
            raise ParameterError(f"{name}: must be finite, got {getattr(camera, name)}")
    for name in ("width", "height"):
        if getattr(camera, name) < 1:
            raise ParameterError(f"{name}: must be ≥ 1 px, got {getattr(camera, name)}")
