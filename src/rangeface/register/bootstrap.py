"""A reference face learned from the frontal images of a user's own gallery."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rangeface.errors import DegenerateError
from rangeface.numerics.resample import mirrored
from rangeface.types import Float32, Orthographic, RangeImage, ReferenceFace

#: Fewer faces than this do not make a mean.
MIN_FACES = 10
#: Deeper than this behind the nose tip a head is ear and neck, not face.
_DEEPEST_MM = 105.0
#: The median's nose tip lies within this of the base's.
_TIP_WITHIN_MM = 20.0
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
        On the grid of the frontal images, its nose tip at the origin; σ is 1.4826 MAD over
        people, or the base's where that is larger.

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
    outline = np.isfinite(_sampled(base, base.image.depth, camera))
    usable = enough & outline & (mirrored(outline.astype(np.float32), camera.cx) > 0)
    median = np.full(usable.shape, np.nan)
    median[usable] = np.nanmedian(both[:, usable], axis=0)
    spread = np.full_like(median, np.nan)
    spread[usable] = 1.4826 * np.nanmedian(np.abs(both[:, usable] - median[usable]), axis=0)
    usable &= median < _DEEPEST_MM
    # a gallery is mostly neutral: how far a mouth moves, only the base knows
    spread = np.fmax(np.fmax(spread, _sampled(base, base.image.sigma, camera)), _FLOOR_MM)
    tip_y, tip_z = _nose_tip(np.where(usable, median, np.nan), camera)
    image = RangeImage(
        np.where(usable, median - tip_z, np.nan),
        replace(camera, cy=camera.cy + tip_y / camera.pitch_mm),
        sigma=np.where(usable, spread, np.nan),
    )
    return ReferenceFace(image, base.landmarks, f"median of {len(frontals)} gallery faces")


def _nose_tip(depth: Float32, camera: Orthographic) -> tuple[float, float]:
    """Height and depth, mm, of the most protruding point of the midline near the origin."""
    columns = np.abs(np.arange(camera.width) - camera.cx) <= 1.0
    rows = np.flatnonzero(
        np.abs(np.arange(camera.height) - camera.cy) * camera.pitch_mm <= _TIP_WITHIN_MM
    )
    profile = depth[np.ix_(rows, columns)].mean(axis=1)
    if not np.isfinite(profile).all():
        return 0.0, 0.0
    k = int(np.clip(profile.argmin(), 1, len(profile) - 2))
    a, b, c = profile[k - 1 : k + 2]
    shift = 0.5 * (a - c) / max(a - 2.0 * b + c, 1e-6)  # vertex of the parabola through three
    y = (rows[k] + np.clip(shift, -0.5, 0.5) - camera.cy) * camera.pitch_mm
    return float(y), float(b - 0.25 * (a - c) * shift)


def _measured(image: RangeImage) -> Float32:
    return image.depth if image.filled is None else np.where(image.filled, np.nan, image.depth)


def _sampled(base: ReferenceFace, plane: Float32 | None, camera: Orthographic) -> Float32:
    """A plane of the base reference at the pixels of another grid, NaN outside."""
    shape = (camera.height, camera.width)
    points = camera.back_project(np.zeros(shape, np.float32))
    uv = np.rint(base.image.camera.project(points)).astype(int)
    height, width = base.image.shape
    inside = (uv[..., 0] >= 0) & (uv[..., 0] < width) & (uv[..., 1] >= 0) & (uv[..., 1] < height)
    out = np.full(shape, np.nan, np.float32)
    if plane is not None:
        out[inside] = plane[uv[inside][:, 1], uv[inside][:, 0]]
    return out
