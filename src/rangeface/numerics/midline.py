"""The profile of a head: where its surface meets the middle plane x = 0 of a frame."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

_STEP_MM = 1.0


class Midline(NamedTuple):
    """Depth along the middle plane, from the brow (y < 0) down to the chin.

    Attributes
    ----------
    y : (n,) float64
        Heights, mm, 1 mm apart.
    z : (n,) float64
        Smoothed depth there, mm; NaN where too little was measured.
    """

    y: NDArray[np.float64]
    z: NDArray[np.float64]


def midline(
    points: NDArray[np.float32],
    weights: NDArray[np.float32],
    rotation: NDArray[np.float64],
    translation: NDArray[np.float64],
    *,
    half_width_mm: float,
    reach_mm: float,
    smooth_mm: float,
) -> Midline:
    """Profile of organised points in the middle plane of a frame.

    Parameters
    ----------
    points : (H, W, 3) float32
        mm, NaN where invalid.
    weights : (H, W) float32
        1/σ² of each point up to a factor, ≥ 0, finite.
    rotation, translation : (3, 3), (3,) float64
        The frame ← camera.
    half_width_mm : float
        Points this far to the side still count, less and less, > 0.
    reach_mm : float
        Points further than this from the origin along y, or in depth, are left out, > 0.
    smooth_mm : float
        σ of the Gaussian window along y, > 0.

    Returns
    -------
    Midline
        2 · reach + 1 samples.
    """
    bins = round(reach_mm / _STEP_MM)
    sums = np.zeros((2, 2 * bins + 1))
    _collect(
        points, weights, np.asarray(rotation, np.float64), np.asarray(translation, np.float64),
        half_width_mm, reach_mm, sums,
    )  # fmt: skip
    y = _STEP_MM * np.arange(-bins, bins + 1, dtype=np.float64)
    window = np.exp(-0.5 * ((y[:, None] - y) / smooth_mm) ** 2)
    total, certainty = window @ sums[1], window @ sums[0]
    enough = certainty > 0.1 * np.median(certainty[certainty > 0]) if certainty.any() else False
    with np.errstate(invalid="ignore", divide="ignore"):
        return Midline(y, np.where(enough, total / certainty, np.nan))


def most_protruding(profile: Midline, *, within_mm: float) -> tuple[float, float] | None:
    """Height and depth of the most protruding point of a profile: the vertex of a parabola.

    Parameters
    ----------
    profile : Midline
        About the expected place.
    within_mm : float
        It is sought within this of y = 0, > 0.

    Returns
    -------
    tuple of float or None
        y and z, mm; None where nothing was measured, or nothing protrudes: the foremost sample
        is the last one that was looked at.

    Examples
    --------
    >>> y = np.arange(-30.0, 31.0)
    >>> y_tip, z_tip = most_protruding(Midline(y, 0.02 * (y - 4.5) ** 2), within_mm=20.0)
    >>> round(y_tip, 3), round(z_tip, 3) + 0.0
    (4.5, 0.0)
    """
    near = np.isfinite(profile.z) & (np.abs(profile.y) <= within_mm)
    y, z = profile.y[near], profile.z[near]
    if len(y) < 7:
        return None
    foremost = int(z.argmin())
    if foremost in (0, len(y) - 1):
        return None
    close = np.abs(y - y[foremost]) <= 5.0
    c, b, a = np.polyfit(y[close] - y[foremost], z[close], 2)
    shift = float(np.clip(-0.5 * b / c, -3.0, 3.0)) if c > 1e-4 else 0.0
    return float(y[foremost] + shift), float(a + shift * (b + shift * c))


@njit(cache=True, nogil=True)
def _collect(points, weights, R, t, half_width, reach, sums):  # type: ignore[no-untyped-def]
    """Add weight and weighted depth of the points near the middle plane to 1 mm of height each."""
    middle = sums.shape[1] // 2
    for i in range(points.shape[0]):
        for j in range(points.shape[1]):
            px, py, pz = points[i, j, 0], points[i, j, 1], points[i, j, 2]
            x = R[0, 0] * px + R[0, 1] * py + R[0, 2] * pz + t[0]
            if not abs(x) < half_width:  # a hole is NaN
                continue
            y = R[1, 0] * px + R[1, 1] * py + R[1, 2] * pz + t[1]
            z = R[2, 0] * px + R[2, 1] * py + R[2, 2] * pz + t[2]
            if abs(y) > reach or abs(z) > reach:
                continue
            w = weights[i, j] * (1.0 - (x / half_width) ** 2)
            k = middle + math.floor(y / _STEP_MM + 0.5)
            sums[0, k] += w
            sums[1, k] += w * z
