"""Curves cut out of a depth image by planes along the optical axis."""

from __future__ import annotations

from math import ceil, inf
from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import gaussian

Float32: TypeAlias = NDArray[np.float32]


def lines(
    depth: ArrayLike,
    origin: ArrayLike,
    angles: ArrayLike,
    *,
    pitch: float,
    reach: float,
    points: int,
    half_width: float = 0.0,
    smoothing: float = 0.0,
    arc_length: bool = True,
    sigma: ArrayLike | None = None,
) -> Float32:
    """Depth along straight lines, at equal steps from a point of each.

    Parameters
    ----------
    depth : (H, W) array_like
        Depth, NaN where invalid.
    origin : (2,) or (n, 2) array_like
        Column and row of the point, px: one for all lines, or one each.
    angles : float or (n,) array_like
        Directions, rad: 0 to the right, π/2 down.
    pitch : float
        Edge of a pixel, in the unit of the depth.
    reach : float
        Length on either side of the origin, same unit, > 0.
    points : int
        Samples on a line, odd, ≥ 3; the middle one is the origin.
    half_width : float
        A sample is the mean, weighted by 1/σ², over a band of this half width, same unit, ≥ 0.
    smoothing : float
        σ of a Gaussian along the line, same unit, ≥ 0.
    arc_length : bool
        Equal steps along the curve; else along the line in the image plane.
    sigma : (H, W) array_like, optional
        Standard deviation of the depth.

    Returns
    -------
    (n, points) float32
        Depth; NaN marks a gap: a hole, or the end of the surface.

    Raises
    ------
    ParameterError
        A parameter is out of range.

    Notes
    -----
    The line is read every half pixel. Arc length bridges a gap by its chord, so that what
    lies behind it keeps its place, but within a gap nothing is interpolated.

    Examples
    --------
    A slope of 45° is √2 long per unit of the image plane:

    >>> slope = np.tile(np.arange(9.0), (3, 1))
    >>> lines(slope, (4, 1), [0.0], pitch=1.0, reach=2 * np.sqrt(2), points=3).round(3)
    array([[2., 4., 6.]], dtype=float32)
    """
    z = np.ascontiguousarray(depth, np.float32)
    if points < 3 or points % 2 == 0:
        raise ParameterError(f"points: must be odd and ≥ 3, got {points}")
    if not 1e-9 <= reach < inf:
        raise ParameterError(f"reach_mm: must be > 0 mm, got {reach}")
    for name, value in (("half_width_mm", half_width), ("smooth_mm", smoothing)):
        if not 0 <= value < inf:
            raise ParameterError(f"{name}: must be ≥ 0 mm, got {value}")
    step = 0.5 * pitch
    count = ceil(reach / step)
    band = round(half_width / step)
    # one row a line: column and row of its point, direction
    origin, angles = np.asarray(origin, np.float64), np.asarray(angles, np.float64)
    line = np.empty((max(angles.size, origin.size // 2), 4))
    line[:, :2], line[:, 2], line[:, 3] = origin, np.cos(angles), np.sin(angles)
    sampled = np.empty((len(line), 2 * count + 1), np.float32)
    spread = z if sigma is None else np.ascontiguousarray(sigma, np.float32)
    if sigma is not None and (spread <= 0).any():
        raise ParameterError("sigma: must be > 0 mm everywhere")
    _sample(z, spread, sigma is not None, line, band, sampled)
    smoothed = gaussian.smooth(sampled[:, None], smoothing / step)[:, 0]
    resampled = np.empty((len(line), points), np.float32)
    _resample(smoothed, step, reach, arc_length, resampled)
    return resampled


def nose_root(profile: ArrayLike, positions: ArrayLike) -> float:
    """Where a central profile is hollowest above the nose tip: the root of the nose.

    Parameters
    ----------
    profile : (n,) array_like
        Depth along the central line, mm, NaN in gaps.
    positions : (n,) array_like
        Height y of the samples, mm, increasing downwards, nose tip at 0.

    Returns
    -------
    float
        y of the sample between 22 and 62 mm above the tip that lies furthest behind the chord
        of that stretch; −42 mm (a typical face) where fewer than five samples are valid.

    Examples
    --------
    >>> y = np.arange(-70.0, 5.0)
    >>> nose_root(np.abs(y + 40) * -0.5, y)
    -40.0
    """
    z, y = np.asarray(profile, np.float64), np.asarray(positions, np.float64)
    use = (y <= -22.0) & (y >= -62.0) & (z == z)
    z, y = z[use], y[use]
    if z.size < 5:
        return -42.0
    chord = z[0] + (z[-1] - z[0]) / (y[-1] - y[0]) * (y - y[0])
    return float(y[(z - chord).argmax()])


# ── kernels ──────────────────────────────────────────────────────────────────────────────


@njit(cache=True, nogil=True)
def _bilinear(f, u, v):  # type: ignore[no-untyped-def]
    """Value at column u and row v; NaN where a pixel with weight is invalid or outside."""
    height, width = f.shape
    if not (0 <= u <= width - 1 and 0 <= v <= height - 1):
        return np.nan
    i, j = min(int(u), max(width - 2, 0)), min(int(v), max(height - 2, 0))
    s, t = u - i, v - j
    value = 0.0
    for dj in range(2):
        for di in range(2):
            weight = (s if di else 1.0 - s) * (t if dj else 1.0 - t)
            if weight > 0.0:
                value += weight * f[j + dj, i + di]
    return value


@njit(cache=True, nogil=True)
def _sample(f, sigma, weighted, lines, band, out):  # type: ignore[no-untyped-def]
    count = out.shape[1] // 2
    for a in range(len(lines)):
        u0, v0, cosine, sine = lines[a]
        for m in range(-count, count + 1):
            total, certainty = 0.0, 0.0
            for n in range(-band, band + 1):
                u = u0 + 0.5 * (m * cosine - n * sine)
                v = v0 + 0.5 * (m * sine + n * cosine)
                value = _bilinear(f, u, v)
                weight = 1.0
                if weighted and value == value:
                    weight = 1.0 / sigma[int(v + 0.5), int(u + 0.5)] ** 2
                if value == value and weight == weight:
                    total += weight * value
                    certainty += weight
            out[a, m + count] = total / certainty if certainty > 0 else np.nan


@njit(cache=True, nogil=True)
def _walk(z, step, reach, arc_length, out):  # type: ignore[no-untyped-def]
    """Resample one half line, z[0] being the origin, at equal distances up to the reach."""
    k = out.size - 1
    distance, previous, target = 0.0, 0, 0
    while target <= k and z[previous] != z[previous] and previous + 1 < z.size:
        previous += 1  # a gap at the origin: the length across it is that of the plane
    distance = previous * step
    while target <= k and target * reach / k < distance - 1e-9:
        out[target] = np.nan
        target += 1
    for m in range(previous, z.size):
        if z[m] != z[m]:
            continue
        run = (m - previous) * step
        length = np.sqrt(run * run + (z[m] - z[previous]) ** 2) if arc_length else run
        while target <= k and target * reach / k <= distance + length + 1e-9:
            part = (target * reach / k - distance) / length if length > 0 else 0.0
            part = min(max(part, 0.0), 1.0)
            inside = m - previous <= 1 or part == 0.0 or part == 1.0
            out[target] = z[previous] + part * (z[m] - z[previous]) if inside else np.nan
            target += 1
        distance += length
        previous = m
    out[target:] = np.nan


@njit(cache=True, nogil=True)
def _resample(sampled, step, reach, arc_length, out):  # type: ignore[no-untyped-def]
    middle, k = sampled.shape[1] // 2, out.shape[1] // 2
    for a in range(len(sampled)):
        _walk(sampled[a, middle:], step, reach, arc_length, out[a, k:])
        _walk(sampled[a, middle::-1], step, reach, arc_length, out[a, k::-1])
