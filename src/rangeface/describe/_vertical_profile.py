"""The central vertical profile."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import camera_of
from rangeface.errors import ParameterError
from rangeface.numerics import holes, profiles, symmetry
from rangeface.types import Float32, RangeImage


def vertical_profile(
    image: RangeImage,
    *,
    by: str = "nose_tip",
    reach_mm: float = 70.0,
    points: int = 71,
    half_width_mm: float = 2.0,
    smooth_mm: float = 2.0,
    arc_length: bool = True,
) -> Float32:
    """Depth along the central vertical profile, from forehead to chin.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    by : {"nose_tip", "symmetry"}
        Straight down through the nose tip, or along the line of mirror symmetry.
    reach_mm : float
        Length above and below the nose tip, mm, > 0.
    points : int
        Samples, odd, ≥ 3; the middle one is the nose tip.
    half_width_mm : float
        Half width of the band that is averaged, mm, ≥ 0, weighted by 1/σ² where σ is known.
    smooth_mm : float
        σ of a Gaussian along the profile, mm, ≥ 0.
    arc_length : bool
        Equal steps along the curve; else equal steps in height.

    Returns
    -------
    (points,) float32
        mm behind the nose tip. A gap (hole, or end of the surface) has the profile's mean; where
        gaps must be told from values, ask `vertical_curve`.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel, or the profile meets none.

    Notes
    -----
    Compared by Pearson's coefficient in the paper (table 5).

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((9, 9)), Orthographic(20.0, 4, 4, 9, 9))
    >>> vertical_profile(flat, points=3)
    array([0., 0., 0.], dtype=float32)
    """
    curve = vertical_curve(
        image,
        by=by,
        reach_mm=reach_mm,
        points=points,
        half_width_mm=half_width_mm,
        smooth_mm=smooth_mm,
        arc_length=arc_length,
    )
    return holes.fill_mean(curve, axis=0)


def vertical_curve(
    image: RangeImage,
    *,
    by: str = "nose_tip",
    reach_mm: float = 70.0,
    points: int = 71,
    half_width_mm: float = 2.0,
    smooth_mm: float = 2.0,
    arc_length: bool = True,
) -> Float32:
    """The profile of `vertical_profile` with its gaps marked by NaN."""
    camera = camera_of(image)
    centre, roll = (camera.cx, camera.cy), 0.0
    if by == "symmetry":
        offset_mm, roll = symmetry_line(image)
        # the point of the line that is level with the nose tip
        centre = (camera.cx + offset_mm / np.cos(roll) / camera.pitch_mm, camera.cy)
    elif by != "nose_tip":
        raise ParameterError(f"by: must be 'nose_tip' or 'symmetry', got {by!r}")
    return profiles.lines(
        image.depth,
        centre,
        [0.5 * np.pi + roll],
        pitch=camera.pitch_mm,
        reach=reach_mm,
        points=points,
        half_width=half_width_mm,
        smoothing=smooth_mm,
        arc_length=arc_length,
        sigma=image.sigma,
    )[0]


def symmetry_line(image: RangeImage) -> tuple[float, float]:
    """Offset (mm, to the right of the nose tip) and roll (rad) of the line of mirror symmetry.

    See `rangeface.numerics.symmetry.mirror_line`.
    """
    camera = camera_of(image)
    return symmetry.mirror_line(image.depth, (camera.cx, camera.cy), pitch=camera.pitch_mm)
