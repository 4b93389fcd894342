"""Gaussian smoothing that knows about holes (normalised convolution)."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.numerics.batches import as_batch

Float32: TypeAlias = NDArray[np.float32]


def smooth(images: ArrayLike, sigma_px: float) -> Float32:
    r"""Images smoothed with a Gaussian over their valid pixels; holes stay holes.

    .. math:: g = \frac{G_σ * (m f)}{G_σ * m}, \quad m = 1 \text{ where valid, else } 0

    Parameters
    ----------
    images : (…, H, W) array_like
        Any unit, NaN where invalid.
    sigma_px : float
        Width of the Gaussian, px, ≥ 0; cut at 3σ; 0 leaves the image as it is.

    Returns
    -------
    (…, H, W) float32
        In the unit of the input, NaN exactly where the input is.

    Raises
    ------
    ParameterError
        The width is negative, not finite, or wider than the image.

    Notes
    -----
    Beyond the edges there is nothing, not zeros: a constant stays constant everywhere.

    References
    ----------
    H. Knutsson, C.-F. Westin, CVPR 1993, doi:10.1109/CVPR.1993.341081.

    Examples
    --------
    >>> smooth([[0.0, 0.0, 4.0, np.nan]], 0.5).round(2)
    array([[0.  , 0.43, 3.52,  nan]], dtype=float32)
    """
    batch, leading = as_batch(images)
    height, width = batch.shape[1:]
    if not (np.isfinite(sigma_px) and 0 <= sigma_px <= max(height, width)):
        raise ParameterError(f"sigma_px: must be 0 … {max(height, width)} px, got {sigma_px}")
    if sigma_px == 0:
        return batch.copy().reshape(*leading, height, width)
    reach = int(np.ceil(3.0 * sigma_px))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma_px) ** 2).astype(np.float32)
    out = np.empty_like(batch)
    _smooth(batch, kernel, out)
    return out.reshape(*leading, height, width)


@njit(cache=True, nogil=True, error_model="numpy")
def _accumulate(weight, value, certainty, total, mass):  # type: ignore[no-untyped-def]
    for u in range(total.size):
        total[u] += weight * value[u]
        mass[u] += weight * certainty[u]


@njit(cache=True, nogil=True, error_model="numpy")
def _smooth(images, kernel, out):  # type: ignore[no-untyped-def]
    n, height, width = images.shape
    reach = kernel.size // 2
    zero, one = np.float32(0.0), np.float32(1.0)
    # values and certainties, columns between margins of nothing
    value, certainty = np.zeros((2, height, width + 2 * reach), np.float32)
    total, mass = np.empty((2, width + 2 * reach), np.float32)
    row, row_mass = np.empty((2, width), np.float32)
    for i in range(n):
        for v in range(height):
            f, target, known = images[i, v], value[v, reach:], certainty[v, reach:]
            for u in range(width):
                target[u] = f[u] if f[u] == f[u] else zero
                known[u] = one if f[u] == f[u] else zero
        for v in range(height):
            total[:] = zero
            mass[:] = zero
            for r in range(max(v - reach, 0), min(v + reach + 1, height)):
                _accumulate(kernel[r - v + reach], value[r], certainty[r], total, mass)
            row[:] = zero
            row_mass[:] = zero
            for k in range(kernel.size):
                _accumulate(kernel[k], total[k:], mass[k:], row, row_mass)
            f, target = images[i, v], out[i, v]
            for u in range(width):
                target[u] = row[u] / row_mass[u] if f[u] == f[u] else f[u]
