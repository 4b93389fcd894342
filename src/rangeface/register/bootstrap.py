"""A reference face learned from the frontal images of a user's own gallery."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rangeface.errors import DegenerateError
from rangeface.numerics.resample import mirrored
from rangeface.types import Float32, Mask, Orthographic, RangeImage, ReferenceFace

#: Fewer faces than this do not make a mean.
MIN_FACES = 10
#: Deeper than this behind the nose tip a head is ear and neck, not face.
_DEEPEST_MM = 105.0
#: No pixel is known better than this, mm.
_FLOOR_MM = 0.5


def bootstrap(frontals: Sequence[RangeImage], base: ReferenceFace) -> ReferenceFace:
    """Median face of a gallery, made symmetric, with the spread between people.

    A reference that resembles the people and the sensor at hand holds more of them than the
    mean of any other population. Only what was measured counts; where fewer than 60 % of the
    faces (and of their mirror images) were, the reference ends.

    Parameters
    ----------
    frontals : sequence of RangeImage
        Frontal images of different people, all on one grid; at least `MIN_FACES`.
    base : ReferenceFace
        The reference that registered them: gives the outline and the landmarks.

    Returns
    -------
    ReferenceFace
        On the grid of the frontal images; σ is 1.4826 MAD over people.

    Raises
    ------
    DegenerateError
        Fewer than `MIN_FACES` images, or different grids.
    """
    if len(frontals) < MIN_FACES:
        raise DegenerateError(f"bootstrap: {len(frontals)} faces; at least {MIN_FACES} are needed")
    camera = frontals[0].camera
    if any(image.camera != camera for image in frontals) or not isinstance(camera, Orthographic):
        raise DegenerateError("bootstrap: the frontal images are on different grids")
    measured = [_measured(image) for image in frontals]
    both = np.stack(measured + [mirrored(depth, camera.cx) for depth in measured])
    enough = np.isfinite(both).mean(axis=0) >= 0.6
    outline = _outline(base, camera)
    usable = enough & outline & (mirrored(outline.astype(np.float32), camera.cx) > 0)
    median = np.full(usable.shape, np.nan)
    median[usable] = np.nanmedian(both[:, usable], axis=0)
    spread = np.full_like(median, np.nan)
    spread[usable] = 1.4826 * np.nanmedian(np.abs(both[:, usable] - median[usable]), axis=0)
    usable &= median < _DEEPEST_MM
    image = RangeImage(
        np.where(usable, median, np.nan),
        camera,
        sigma=np.where(usable, np.maximum(spread, _FLOOR_MM), np.nan),
    )
    return ReferenceFace(image, base.landmarks, f"median of {len(frontals)} gallery faces")


def _measured(image: RangeImage) -> Float32:
    return image.depth if image.filled is None else np.where(image.filled, np.nan, image.depth)


def _outline(base: ReferenceFace, camera: Orthographic) -> Mask:
    """Where the base reference has a face, seen on another grid."""
    shape = (camera.height, camera.width)
    points = camera.back_project(np.zeros(shape, np.float32))
    uv = np.rint(base.image.camera.project(points)).astype(int)
    height, width = base.image.shape
    inside = (uv[..., 0] >= 0) & (uv[..., 0] < width) & (uv[..., 1] >= 0) & (uv[..., 1] < height)
    outline = np.zeros(shape, bool)
    outline[inside] = base.image.mask[uv[inside][:, 1], uv[inside][:, 0]]
    return outline
