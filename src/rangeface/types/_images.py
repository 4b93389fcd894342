"""Range images and point sets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.types._arrays import Float32, Mask, frozen
from rangeface.types._cameras import Camera


@dataclass(frozen=True, eq=False)
class RangeImage:
    """A depth image with its camera, and what is known of its noise.

    Parameters
    ----------
    depth : (H, W) array_like
        Depth z, mm; NaN marks an invalid pixel. Stored as read-only float32.
    camera : Pinhole or Orthographic
        Of the same size.
    sigma : (H, W) array_like, optional
        Standard deviation of the depth, mm, per pixel.
    amplitude : (H, W) array_like, optional
        Amplitude of the received light, sensor counts.
    filled : (H, W) array_like of bool, optional
        Pixels whose depth was not measured but filled in (denoising, mirroring, reference).

    Raises
    ------
    ParameterError
        A size differs from the camera's, or a depth is infinite.

    Examples
    --------
    >>> from rangeface.types import Pinhole
    >>> image = RangeImage([[400.0, np.nan]], Pinhole(200, 200, 0.5, 0, 2, 1))
    >>> image.mask
    array([[ True, False]])
    >>> image.points[0, 0]
    array([ -1.,   0., 400.], dtype=float32)
    """

    depth: Float32
    camera: Camera
    sigma: Float32 | None = None
    amplitude: Float32 | None = None
    filled: Mask | None = None

    def __post_init__(self) -> None:
        shape = (self.camera.height, self.camera.width)
        object.__setattr__(self, "depth", frozen(self.depth, np.float32, "depth", shape))
        if np.isinf(self.depth).any():
            raise ParameterError("depth: infinite values; mark invalid pixels with NaN")
        for name, dtype in (("sigma", np.float32), ("amplitude", np.float32), ("filled", np.bool_)):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, frozen(value, dtype, name, shape))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.camera.height, self.camera.width

    @cached_property
    def mask(self) -> Mask:
        """Which pixels are valid, (H, W) bool."""
        mask = np.isfinite(self.depth)
        mask.flags.writeable = False
        return mask

    @cached_property
    def points(self) -> Float32:
        """Points in the camera frame, (H, W, 3) mm, NaN where invalid."""
        points = self.camera.back_project(self.depth)
        points.flags.writeable = False
        return points

    def with_depth(self, depth: ArrayLike, **changes: Any) -> RangeImage:
        """The same image with another depth, and with any other field changed."""
        return replace(self, depth=np.asarray(depth, np.float32), **changes)

    def masked(self, keep: ArrayLike) -> RangeImage:
        """The same image with everything outside `keep` (H, W bool) made invalid."""
        return replace(self, depth=np.where(np.asarray(keep, dtype=bool), self.depth, np.nan))

    def crop(self, left: int, top: int, width: int, height: int) -> RangeImage:
        """The window whose first pixel is (left, top), clipped to the image, with its camera.

        Raises
        ------
        ParameterError
            The window lies outside the image.
        """
        rows = slice(max(top, 0), min(top + height, self.camera.height))
        cols = slice(max(left, 0), min(left + width, self.camera.width))
        h, w = rows.stop - rows.start, cols.stop - cols.start
        if h < 1 or w < 1:
            raise ParameterError(
                f"crop: window ({left}, {top}, {width}, {height}) is outside the image"
            )
        planes = {
            name: None if (plane := getattr(self, name)) is None else plane[rows, cols]
            for name in ("sigma", "amplitude", "filled")
        }
        camera = self.camera.crop(cols.start, rows.start, w, h)
        return RangeImage(self.depth[rows, cols], camera, **planes)


@dataclass(frozen=True, eq=False)
class PointSet:
    """Points, and triangles between them if the source had any.

    Parameters
    ----------
    points : (n, 3) array_like
        Points, mm, all finite, in the camera frame's axes (x right, y down, z forward).
    triangles : (m, 3) array_like of int, optional
        Indices into `points`, all in range.

    Raises
    ------
    ParameterError
        A shape is wrong, a point is not finite, or an index is out of range.
    """

    points: Float32
    triangles: NDArray[np.int32] | None = None

    def __post_init__(self) -> None:
        points = frozen(self.points, np.float32, "points", None)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ParameterError(f"points: expected (n, 3), got {points.shape}")
        if not np.isfinite(points).all():
            raise ParameterError("points: not all finite; drop invalid points first")
        object.__setattr__(self, "points", points)
        if self.triangles is not None:
            triangles = frozen(self.triangles, np.int32, "triangles", None)
            if triangles.ndim != 2 or triangles.shape[1] != 3:
                raise ParameterError(f"triangles: expected (m, 3), got {triangles.shape}")
            if triangles.size and (triangles.min() < 0 or triangles.max() >= len(points)):
                raise ParameterError("triangles: an index is outside the points")
            object.__setattr__(self, "triangles", triangles)
