r"""Moving least squares: scattered points of a surface onto a regular grid, once.

Around each grid point a plane :math:`z = a + b u + c v` is fitted to the points nearby,

.. math:: \min_{a,b,c} \sum_k g(u_k, v_k) \, w_k \, (a + b u_k + c v_k - z_k)^2,

with a Gaussian window g and the points' weights :math:`w_k = 1/σ_k^2`
(Lancaster and Salkauskas, doi:10.1090/S0025-5718-1981-0616367-1); :math:`a` is the depth.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}
#: The window is cut off at this many standard deviations.
_REACH = 2.5
#: A point this far (mm) behind the nearest surface at its grid point belongs to another surface.
_LAYER_MM = 20.0


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _nearest_surface(points, height, width):  # type: ignore[no-untyped-def]
    """Smallest z in each grid cell's 3 × 3 neighbourhood; points (n, 3) as column, row, z."""
    front = np.full((height, width), np.inf, np.float32)
    for k in range(points.shape[0]):
        col = math.floor(points[k, 0] + 0.5)
        row = math.floor(points[k, 1] + 0.5)
        for i in range(max(row - 1, 0), min(row + 2, height)):
            for j in range(max(col - 1, 0), min(col + 2, width)):
                front[i, j] = min(front[i, j], points[k, 2])
    return front


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def moving_least_squares(points, weights, values, height, width, sigma_px, min_weight):  # type: ignore[no-untyped-def]
    """Resample points and the values that they carry to an (height, width) grid.

    Parameters
    ----------
    points : (n, 3) float32
        Column, row (both in grid pixels) and depth z (mm).
    weights : (n,) float32
        1/σ² (mm⁻²) of each point, finite, > 0.
    values : (n, c) float32
        What else each point carries (amplitude, …); averaged with the same window.
    height, width : int
        Size of the grid.
    sigma_px : float32
        Standard deviation of the Gaussian window, grid pixels.
    min_weight : float32
        Grid points whose window sums to less (a point at its centre counts 1) stay NaN.

    Returns
    -------
    depth : (height, width) float32
        a of the plane; NaN where there is too little.
    variance : (height, width) float32
        Of the local mean, mm²: Σ g² w / (Σ g w)².
    averages : (height, width, c) float32

    Notes
    -----
    Where the points do not spread around the grid point (the border of a hole) the plane is
    not determined and the weighted mean is taken instead.
    """
    channels = values.shape[1]
    front = _nearest_surface(points, height, width)
    # moments: g | gw, gw(u, v, uu, uv, vv), gw z(1, u, v), g²w
    M = np.zeros((height, width, 11), np.float32)
    averages = np.zeros((height, width, channels), np.float32)
    reach = _REACH * sigma_px
    spread = np.float32(-0.5) / (sigma_px * sigma_px)
    for k in range(points.shape[0]):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        for i in range(max(math.ceil(y - reach), 0), min(int(y + reach) + 1, height)):
            v = y - i
            for j in range(max(math.ceil(x - reach), 0), min(int(x + reach) + 1, width)):
                if z > front[i, j] + np.float32(_LAYER_MM):
                    continue
                u = x - j
                g = math.exp(spread * (u * u + v * v))
                w = g * weights[k]
                m = M[i, j]
                m[0] += g
                m[1] += w
                m[2] += w * u
                m[3] += w * v
                m[4] += w * u * u
                m[5] += w * u * v
                m[6] += w * v * v
                m[7] += w * z
                m[8] += w * z * u
                m[9] += w * z * v
                m[10] += g * w
                for c in range(channels):
                    averages[i, j, c] += w * values[k, c]
    depth = np.full((height, width), np.nan, np.float32)
    variance = np.full((height, width), np.nan, np.float32)
    for i in range(height):
        for j in range(width):
            m = M[i, j]
            if m[0] < min_weight:
                averages[i, j, :] = np.nan
                continue
            averages[i, j, :] /= m[1]
            variance[i, j] = m[10] / (m[1] * m[1])
            depth[i, j] = _intercept(m, sigma_px)
    return depth, variance, averages


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _intercept(m, sigma_px):  # type: ignore[no-untyped-def]
    """Depth at the grid point from the moments: the plane's, or the mean where it is open."""
    W = m[1]
    mu, mv, mz = m[2] / W, m[3] / W, m[7] / W
    cuu = m[4] / W - mu * mu
    cuv = m[5] / W - mu * mv
    cvv = m[6] / W - mv * mv
    det = cuu * cvv - cuv * cuv
    full = np.float32(0.25) * sigma_px * sigma_px  # half the spread of a filled window, squared
    if det < np.float32(0.25) * full * full or mu * mu + mv * mv > sigma_px * sigma_px:
        return mz
    czu = m[8] / W - mz * mu
    czv = m[9] / W - mz * mv
    slope_u = (czu * cvv - czv * cuv) / det
    slope_v = (czv * cuu - czu * cuv) / det
    return mz - slope_u * mu - slope_v * mv


def inverse_variances(sigma: NDArray[np.float32]) -> NDArray[np.float32]:
    """1/σ² of points, bounded by what is typical.

    Parameters
    ----------
    sigma : (n,) float32
        mm; NaN or ≤ 0 where unknown.

    Returns
    -------
    (n,) float32
        mm⁻²: at most 16 times, and where σ is unknown a sixteenth of, that of the median σ
        (of 1 mm if none is known).

    Examples
    --------
    >>> inverse_variances(np.array([2.0, 2.0, 0.1, np.nan], np.float32))
    array([0.25    , 0.25    , 4.      , 0.015625], dtype=float32)
    """
    known = np.isfinite(sigma) & (sigma > 0)
    typical = float(np.median(sigma[known])) if known.any() else 1.0
    bounded = np.where(known, np.maximum(sigma, 0.25 * typical), 4.0 * typical)
    return (1.0 / bounded**2).astype(np.float32)


def mirrored(plane: NDArray[np.float32], axis_column: float) -> NDArray[np.float32]:
    """A plane (H, W) mirrored about a column: c takes the value of 2·axis − c, NaN outside.

    Parameters
    ----------
    plane : (H, W) float32
    axis_column : float
        Column of the axis; half columns (the axis between two pixels) are exact.

    Returns
    -------
    (H, W) float32

    Examples
    --------
    >>> mirrored(np.array([[1.0, 2.0, 3.0]], np.float32), 0.5)
    array([[ 2.,  1., nan]], dtype=float32)
    """
    width = plane.shape[1]
    source = np.rint(2.0 * axis_column - np.arange(width)).astype(int)
    inside = (source >= 0) & (source < width)
    out = np.full_like(plane, np.nan)
    out[:, inside] = plane[:, source[inside]]
    return out
