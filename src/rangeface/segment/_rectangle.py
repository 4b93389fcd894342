"""The rectangle crop: a box around the nose tip, seen along its depth, on a grid of any size."""

from __future__ import annotations

import numpy as np

from rangeface.errors import NoFaceError, ParameterError
from rangeface.numerics.resample import inverse_variances, moving_least_squares
from rangeface.types import Orthographic, RangeImage, RigidTransform


def rectangle(
    image: RangeImage,
    pose: RigidTransform,
    *,
    width_mm: float = 100.0,
    height_mm: float = 160.0,
    depth_mm: float = 140.0,
    width: int = 50,
    height: int = 80,
) -> RangeImage:
    """The rectangle around a nose tip, resized to a grid of pixels.

    Parameters
    ----------
    image : RangeImage
        Any camera.
    pose : RigidTransform
        T_face_camera: a face's `pose`, an alignment's `transform`, or only a shift of the nose
        tip to the origin.
    width_mm, height_mm : float
        Extent across and along the face, mm, > 0; both must give the same pitch.
    depth_mm : float
        Points this far before or behind the nose tip are dropped, > 0.
    width, height : int
        Size of the grid, px.

    Returns
    -------
    RangeImage
        Orthographic, (height, width), nose tip at its centre, depth relative to it; with σ and
        amplitude where the image has them. Holes stay holes.

    Raises
    ------
    ParameterError
        An extent is not positive, or the pixels are not square.
    NoFaceError
        No point of the image lies in the rectangle.

    Notes
    -----
    Depths are resampled by moving least squares; the window is one pixel, or wider where the
    image's own pixels are coarser than the grid's.

    Examples
    --------
    >>> from rangeface.types import Pinhole
    >>> wall = RangeImage(np.full((90, 80), 400.0), Pinhole(200, 200, 39.5, 44.5, 80, 90))
    >>> crop = rectangle(wall, RigidTransform(np.eye(3), [0.0, 0.0, -390.0]))
    >>> crop.shape, round(float(crop.depth[40, 25]), 3)
    ((80, 50), 10.0)
    """
    for name, value in (
        ("width_mm", width_mm), ("height_mm", height_mm), ("depth_mm", depth_mm)
    ):  # fmt: skip
        if not value > 0:
            raise ParameterError(f"{name} must be > 0, got {value}")
    camera = Orthographic.centred(width_mm, height_mm, width, height)
    points = pose.apply(image.points[image.mask])
    scattered = np.column_stack([camera.project(points), points[:, 2]]).astype(np.float32)
    column, row, z = scattered.T
    margin = 0.5 * max(width, height)  # for the windows that reach in from outside
    inside = (np.abs(column - camera.cx) <= 0.5 * width + margin) & (
        np.abs(row - camera.cy) <= 0.5 * height + margin
    )
    inside &= np.abs(z) <= depth_mm
    if not inside.any():
        raise NoFaceError("no point of the image lies in the rectangle")
    weights = (
        np.ones(int(inside.sum()), np.float32)
        if image.sigma is None
        else inverse_variances(image.sigma[image.mask][inside])
    )
    carried = (
        np.empty((len(weights), 0), np.float32)
        if image.amplitude is None
        else np.nan_to_num(image.amplitude[image.mask][inside]).astype(np.float32)[:, None]
    )
    spacing = image.camera.pixel_mm(float(pose.inverse().translation[2])) / camera.pitch_mm
    depth, variance, averages = moving_least_squares(
        scattered[inside], weights, carried, height, width,
        np.float32(max(1.0, 0.8 * spacing)), np.float32(0.3),
    )  # fmt: skip
    return RangeImage(
        depth,
        camera,
        sigma=None if image.sigma is None else np.sqrt(variance),
        amplitude=None if image.amplitude is None else averages[..., 0],
    )
