"""Radial curves from the nose tip."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import camera_of
from rangeface.errors import ParameterError
from rangeface.numerics import holes, profiles
from rangeface.types import Float32, RangeImage


def radial_curves(
    image: RangeImage,
    *,
    curves: int = 24,
    reach_mm: float = 70.0,
    points: int = 35,
    half_width_mm: float = 1.0,
    smooth_mm: float = 2.0,
    arc_length: bool = True,
) -> Float32:
    """Depth along curves that radiate from the nose tip, in the style of Drira et al.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    curves : int
        Number of curves, even, ≥ 2: the first to the right, the others clockwise as displayed.
    reach_mm : float
        Length of a curve, mm, > 0.
    points : int
        Samples on a curve, ≥ 1; the nose tip, common to all, is not among them.
    half_width_mm, smooth_mm, arc_length
        As for `vertical_profile`.

    Returns
    -------
    (curves · points,) float32
        mm behind the nose tip, curve after curve. A gap has the mean of the other curves at the
        same distance from the nose tip; where there is none, the mean of all.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel, or the curves meet none.

    Notes
    -----
    Sampled depth, not the elastic shape metric of the source.

    References
    ----------
    H. Drira, B. Ben Amor, A. Srivastava, M. Daoudi, R. Slama, IEEE TPAMI 35(9), 2013,
    doi:10.1109/TPAMI.2013.48.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((9, 9)), Orthographic(20.0, 4, 4, 9, 9))
    >>> radial_curves(flat).shape
    (840,)
    """
    camera = camera_of(image)
    if curves < 2 or curves % 2:
        raise ParameterError(f"curves: must be even and ≥ 2, got {curves}")
    if points < 1:
        raise ParameterError(f"points: must be ≥ 1, got {points}")
    through = profiles.lines(
        image.depth,
        (camera.cx, camera.cy),
        2.0 * np.pi * np.arange(curves // 2) / curves,
        pitch=camera.pitch_mm,
        reach=reach_mm,
        points=2 * points + 1,
        half_width=half_width_mm,
        smoothing=smooth_mm,
        arc_length=arc_length,
        sigma=image.sigma,
    )
    # a line's second half is one curve, its first half, read backwards, the opposite one
    radial = np.concatenate([through[:, points + 1 :], through[:, points - 1 :: -1]])
    found = np.isfinite(radial)
    count = np.maximum(found.sum(axis=0), 1)
    ring = np.where(found, radial, 0.0).sum(axis=0) / count
    ring[~found.any(axis=0)] = np.nan
    return holes.fill_mean(np.where(found, radial, ring)).ravel()
