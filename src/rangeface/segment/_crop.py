"""From a pose to a face: crop by a sphere, and carry the reference's landmarks over."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rangeface.errors import ParameterError
from rangeface.numerics.pose_search import within
from rangeface.types import Face, Float64, RangeImage, ReferenceFace, RigidTransform


def face_at(
    image: RangeImage,
    reference: ReferenceFace,
    pose: RigidTransform,
    confidence: float,
    radius_mm: float,
) -> Face:
    """The face whose reference lies at `pose` (camera←face), cropped by a sphere."""
    return Face(
        image=sphere(image, pose.translation, radius_mm),
        nose_tip=pose.translation,
        landmarks={name: pose.apply(point) for name, point in reference.landmarks.items()},
        confidence=confidence,
        pose=pose.inverse(),
    )


def sphere(image: RangeImage, centre: ArrayLike, radius_mm: float) -> RangeImage:
    """The smallest window of an image that holds its points within a sphere; no other point.

    Parameters
    ----------
    image : RangeImage
        Any camera.
    centre : (3,) array_like
        Centre of the sphere in the camera frame, mm: the nose tip.
    radius_mm : float
        > 0.

    Returns
    -------
    RangeImage
        With the window's camera; without a valid pixel where the sphere meets no surface.

    Raises
    ------
    ParameterError
        The radius is not positive.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> wall = RangeImage(np.full((9, 9), 400.0), Orthographic(10.0, 4.0, 4.0, 9, 9))
    >>> sphere(wall, [0.0, 0.0, 400.0], 25.0).mask.sum()
    np.int64(21)
    """
    if not radius_mm > 0:
        raise ParameterError(f"radius_mm must be > 0, got {radius_mm}")
    centre = np.asarray(centre, np.float64)
    window = around(image, centre, radius_mm)
    inside = within(window.points, centre, radius_mm)
    rows, cols = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    if len(rows) == 0:
        return window.masked(inside)
    return window.masked(inside).crop(
        int(cols[0]), int(rows[0]), int(cols[-1] - cols[0]) + 1, int(rows[-1] - rows[0]) + 1
    )


def around(image: RangeImage, centre: Float64, radius_mm: float) -> RangeImage:
    """The window that the cube around a sphere projects to, whatever else lies in it."""
    low, high = centre - radius_mm, centre + radius_mm
    camera = image.camera
    if camera.projection.perspective:
        if low[2] <= 1.0:
            return image
        depths = np.array([low[2], high[2]])  # the rays to the cube's corners
        low = np.append((low[:2, None] / depths).min(axis=1), 1.0)
        high = np.append((high[:2, None] / depths).max(axis=1), 1.0)
    left, top = np.floor(camera.project(low)).astype(int)
    right, bottom = np.ceil(camera.project(high)).astype(int)
    last_row, last_col = image.shape[0] - 1, image.shape[1] - 1
    left, right = min(max(left, 0), last_col), min(max(right, 0), last_col)
    top, bottom = min(max(top, 0), last_row), min(max(bottom, 0), last_row)
    return image.crop(int(left), int(top), int(right - left) + 1, int(bottom - top) + 1)
