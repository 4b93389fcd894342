r"""Local least-squares polynomials over a disc around every pixel, with their covariance.

.. math:: f(u + i, v + j) ≈ c_0 + c_1 i + c_2 j + c_3 \tfrac{i^2}{2} + c_4\, i j
          + c_5 \tfrac{j^2}{2}, \qquad i^2 + j^2 ≤ r^2

The coefficients are the value, the gradient and the second derivatives at the pixel, per px
and per px². Residuals are weighted by 1/σ²; then Cov(c) = (Φᵀ W Φ)⁻¹ exactly.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import cholesky
from rangeface.numerics.batches import as_batch

Float32: TypeAlias = NDArray[np.float32]

TERMS = {1: 3, 2: 6}
"""Number of coefficients by degree."""


def fit(
    images: ArrayLike, *, sigma: ArrayLike | None = None, radius_px: float = 2.0, degree: int = 2
) -> Float32:
    """Coefficients of the polynomial that fits best around every pixel.

    Parameters
    ----------
    images : (…, H, W) array_like
        Values, NaN where invalid.
    sigma : (…, H, W) array_like, optional
        Standard deviation of the values, > 0; a sample whose σ is NaN is left out.
    radius_px : float
        Radius of the disc, px, 1 … 15; a quadric needs at least √2.
    degree : {1, 2}
        Plane or quadric.

    Returns
    -------
    (…, H, W, 3 or 6) float32
        Value, gradient and (degree 2) second derivatives; NaN where the pixel is invalid or
        its disc determines no polynomial of this degree.

    Raises
    ------
    ParameterError
        The radius or the degree is out of range, the image is smaller than 3 × 3, or σ does
        not match.

    Examples
    --------
    >>> j, i = np.mgrid[0:7, 0:7].astype(float)
    >>> fit(2 * i - j + 0.5 * i * j, radius_px=2)[3, 3].round(4) + 0.0
    array([7.5, 3.5, 0.5, 0. , 0.5, 0. ], dtype=float32)
    """
    coefficients, _, leading = _run(images, sigma, radius_px, degree, False)
    return coefficients.reshape(*leading, *coefficients.shape[1:])


def fit_with_covariance(
    images: ArrayLike, *, sigma: ArrayLike, radius_px: float = 2.0, degree: int = 2
) -> tuple[Float32, Float32]:
    """Coefficients as by `fit`, and their covariance.

    Parameters
    ----------
    images, radius_px, degree
        As for `fit`.
    sigma : (…, H, W) array_like
        Standard deviation of the values; noise is taken to be independent between pixels.

    Returns
    -------
    coefficients : (…, H, W, k) float32
    covariance : (…, H, W, k, k) float32

    Raises
    ------
    ParameterError
        As for `fit`.

    Examples
    --------
    >>> c, C = fit_with_covariance(np.zeros((5, 5)), sigma=np.ones((5, 5)), radius_px=1, degree=1)
    >>> C[2, 2].diagonal().round(3)  # five samples: 1/5, 1/2, 1/2
    array([0.2, 0.5, 0.5], dtype=float32)
    """
    coefficients, covariance, leading = _run(images, sigma, radius_px, degree, True)
    return (
        coefficients.reshape(*leading, *coefficients.shape[1:]),
        covariance.reshape(*leading, *covariance.shape[1:]),
    )


def _run(
    images: ArrayLike, sigma: ArrayLike | None, radius_px: float, degree: int, want: bool
) -> tuple[Float32, Float32, tuple[int, ...]]:
    if degree not in TERMS:
        raise ParameterError(f"degree: must be one of {sorted(TERMS)}, got {degree}")
    if not 1 <= radius_px <= 15:
        raise ParameterError(f"radius_px: must be 1 … 15 px, got {radius_px}")
    batch, leading = as_batch(images, at_least=3)
    if sigma is None:
        weights = np.ones((1, 1, 1), np.float32)
    else:
        spread, _ = as_batch(sigma)
        if spread.shape[1:] != batch.shape[1:] or spread.shape[0] not in (1, len(batch)):
            raise ParameterError(f"sigma: shape {spread.shape} does not match {batch.shape}")
        if (spread <= 0).any():
            raise ParameterError("sigma: must be > 0 mm everywhere")
        weights = 1.0 / (spread * spread)
    k = TERMS[degree]
    coefficients = np.full((*batch.shape, k), np.nan, np.float32)
    covariance = np.empty((*batch.shape, k, k) if want else (0, 0, 0, k, k), np.float32)
    if sigma is None:
        _filter(batch, *_filters(float(radius_px), degree), coefficients)
    _fit(batch, weights, sigma is not None, float(radius_px), coefficients, covariance)
    return coefficients, covariance, leading


@lru_cache(maxsize=32)
def _filters(radius_px: float, degree: int) -> tuple[NDArray[np.int64], Float32]:
    """Offsets (m, 2: row, column) of a complete disc, and the filter (k, m) of each coefficient.

    Without weights every complete disc has the same normal equations, so that its fit is a linear
    filter (Savitzky and Golay, doi:10.1021/ac60214a047). Empty where the disc has too few pixels.
    """
    reach = int(radius_px)
    j, i = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    inside = i * i + j * j <= radius_px * radius_px
    j, i = j[inside], i[inside]
    basis = np.stack([np.ones(i.shape), i, j, 0.5 * i * i, i * j, 0.5 * j * j])[: TERMS[degree]]
    if np.linalg.matrix_rank(basis) < TERMS[degree]:
        return np.empty((0, 2), np.int64), np.empty((TERMS[degree], 0), np.float32)
    return np.stack([j, i], axis=-1), np.linalg.pinv(basis.T).astype(np.float32)


# ── kernels ──────────────────────────────────────────────────────────────────────────────


@njit(cache=True, nogil=True)
def _basis(i, j, phi):  # type: ignore[no-untyped-def]
    phi[0], phi[1], phi[2] = 1.0, i, j
    if phi.size == 6:
        phi[3], phi[4], phi[5] = 0.5 * i * i, i * j, 0.5 * j * j


@njit(cache=True, nogil=True)
def _moments(f, w, weighted, v, u, radius, phi, A, y):  # type: ignore[no-untyped-def]
    """Normal equations A c = y of one disc, offsets in units of its radius."""
    height, width = f.shape
    reach = int(radius)
    A[:] = 0.0
    y[:] = 0.0
    for j in range(max(-reach, -v), min(reach, height - 1 - v) + 1):
        for i in range(max(-reach, -u), min(reach, width - 1 - u) + 1):
            value = np.float64(f[v + j, u + i]) - np.float64(f[v, u])
            weight = np.float64(w[v + j, u + i]) if weighted else 1.0
            if i * i + j * j > radius * radius or value != value or weight != weight:
                continue
            _basis(i / radius, j / radius, phi)
            for r in range(phi.size):
                y[r] += weight * phi[r] * value
                for c in range(r + 1):
                    A[r, c] += weight * phi[r] * phi[c]


@njit(cache=True, nogil=True)
def _filter(images, offsets, filters, coefficients):  # type: ignore[no-untyped-def]
    """Fit every disc that is complete; any other sums to NaN and stays open."""
    n, height, width = images.shape
    k, samples = filters.shape
    if samples == 0:
        return
    reach = offsets.max()
    inner = max(width - 2 * reach, 0)
    total = np.empty((k, inner), np.float32)
    for m in range(n):
        for v in range(reach, height - reach):
            here = images[m, v, reach:]
            total[:] = 0.0
            for s in range(samples):
                there = images[m, v + offsets[s, 0], reach + offsets[s, 1] :]
                for t in range(k):
                    weight, row = filters[t, s], total[t]
                    for u in range(inner):
                        row[u] += weight * (there[u] - here[u])
            for t in range(k):
                for u in range(inner):
                    coefficients[m, v, reach + u, t] = total[t, u]
            for u in range(inner):
                coefficients[m, v, reach + u, 0] += here[u]


@njit(cache=True, nogil=True)
def _fit(images, weights, weighted, radius, coefficients, covariance):  # type: ignore[no-untyped-def]
    """Solve the normal equations of every disc whose coefficients are still open."""
    n, height, width = images.shape
    k = coefficients.shape[3]
    phi, y, A = np.empty(k), np.empty(k), np.empty((k, k))
    scale = np.ones(k)
    for t in range(1, k):
        scale[t] = 1.0 / radius if t < 3 else 1.0 / radius**2
    for m in range(n):
        w = weights[m % weights.shape[0]]
        for v in range(height):
            for u in range(width):
                here = images[m, v, u]
                if coefficients[m, v, u, 0] == coefficients[m, v, u, 0]:
                    continue
                _moments(images[m], w, weighted, v, u, radius, phi, A, y)
                if here != here or not cholesky.factor(A):
                    coefficients[m, v, u] = np.nan
                    if covariance.size:
                        covariance[m, v, u] = np.nan
                    continue
                cholesky.solve(A, y)
                for t in range(k):
                    coefficients[m, v, u, t] = y[t] * scale[t]
                coefficients[m, v, u, 0] += here
                for c in range(k if covariance.size else 0):
                    y[:] = 0.0
                    y[c] = 1.0
                    cholesky.solve(A, y)
                    for t in range(k):
                        covariance[m, v, u, t, c] = y[t] * scale[t] * scale[c]
