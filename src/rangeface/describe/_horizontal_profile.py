"""Horizontal profiles through nose, nose root and forehead."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rangeface.describe._frontal import camera_of
from rangeface.describe._vertical_profile import vertical_curve
from rangeface.errors import ParameterError
from rangeface.numerics import holes, profiles
from rangeface.types import Float32, RangeImage

PLACES = ("nose", "root", "forehead")
"""Where the paper cuts: through the nose tip, the root of the nose, the forehead."""

CENTRAL_MM = np.linspace(-70.0, 70.0, 71)
"""Heights at which the central line is read for the root of the nose, mm."""


def horizontal_profile(
    image: RangeImage,
    *,
    at: str = "nose",
    forehead_mm: float = 28.0,
    reach_mm: float = 60.0,
    points: int = 61,
    half_width_mm: float = 2.0,
    smooth_mm: float = 2.0,
    arc_length: bool = True,
) -> Float32:
    """Depth along a horizontal profile, from the left of the image to its right.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    at : {"nose", "root", "forehead"}
        Through the nose tip, the root of the nose, or a fixed height above that root.
    forehead_mm : float
        That height, mm; the paper does not say.
    reach_mm : float
        Length to the left and right of the centre, mm, > 0.
    points : int
        Samples, odd, ≥ 3; the middle one is above or at the nose tip.
    half_width_mm, smooth_mm, arc_length
        As for `vertical_profile`.

    Returns
    -------
    (points,) float32
        mm behind the nose tip. A gap has the profile's mean; where gaps must be told from
        values, ask `horizontal_curve`.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel, or the profile meets none.

    Notes
    -----
    The root is where the central profile is hollowest between 22 and 62 mm above the tip.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((9, 9)), Orthographic(20.0, 4, 4, 9, 9))
    >>> horizontal_profile(flat, points=3)
    array([0., 0., 0.], dtype=float32)
    """
    curve = horizontal_curve(
        image,
        at=at,
        forehead_mm=forehead_mm,
        reach_mm=reach_mm,
        points=points,
        half_width_mm=half_width_mm,
        smooth_mm=smooth_mm,
        arc_length=arc_length,
    )
    return holes.fill_mean(curve, axis=0)


def horizontal_curve(
    image: RangeImage,
    *,
    at: str = "nose",
    forehead_mm: float = 28.0,
    reach_mm: float = 60.0,
    points: int = 61,
    half_width_mm: float = 2.0,
    smooth_mm: float = 2.0,
    arc_length: bool = True,
) -> Float32:
    """The profile of `horizontal_profile` with its gaps marked by NaN."""
    return horizontal_curves(
        image,
        [profile_height(image, at, forehead_mm=forehead_mm)],
        reach_mm=reach_mm,
        points=points,
        half_width_mm=half_width_mm,
        smooth_mm=smooth_mm,
        arc_length=arc_length,
    )[0]


def horizontal_curves(
    image: RangeImage,
    heights_mm: Sequence[float],
    *,
    reach_mm: float,
    points: int,
    half_width_mm: float,
    smooth_mm: float,
    arc_length: bool,
) -> Float32:
    """Horizontal profiles (n, points) at heights y, mm, gaps marked by NaN."""
    camera = camera_of(image)
    return profiles.lines(
        image.depth,
        [(camera.cx, camera.cy + y / camera.pitch_mm) for y in heights_mm],
        0.0,
        pitch=camera.pitch_mm,
        reach=reach_mm,
        points=points,
        half_width=half_width_mm,
        smoothing=smooth_mm,
        arc_length=arc_length,
        sigma=image.sigma,
    )


def profile_height(image: RangeImage, at: str, *, forehead_mm: float = 28.0) -> float:
    """Height y, mm (down is positive), at which a horizontal profile cuts the face."""
    if at not in PLACES:
        raise ParameterError(f"at: must be one of {PLACES}, got {at!r}")
    return 0.0 if at == "nose" else root_height(image) - (forehead_mm if at == "forehead" else 0.0)


def root_height(image: RangeImage) -> float:
    """Height y, mm, of the root of the nose on the central line."""
    central = vertical_curve(image, reach_mm=70.0, points=CENTRAL_MM.size, arc_length=False)
    return profiles.nose_root(central, CENTRAL_MM)
