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
def _accumulate(target, source, weight):  # type: ignore[no-untyped-def]
    for u in range(target.size):
        target[u] += weight * source[u]


@njit(cache=True, nogil=True, error_model="numpy")
def _smooth(images, kernel, out):  # type: ignore[no-untyped-def]
    n, height, width = images.shape
    reach = kernel.size // 2
    # values and certainties, between margins of nothing
    value = np.zeros((height + 2 * reach, width + 2 * reach), np.float32)
    certainty = np.zeros_like(value)
    row, row_certainty = np.empty((2, width + 2 * reach), np.float32)
    for i in range(n):
        for v in range(height):
            for u in range(width):
                f = images[i, v, u]
                valid = f == f
                value[v + reach, u + reach] = f if valid else np.float32(0.0)
                certainty[v + reach, u + reach] = np.float32(1.0) if valid else np.float32(0.0)
        for v in range(height):
            row[:] = np.float32(0.0)
            row_certainty[:] = np.float32(0.0)
            for k in range(kernel.size):
                _accumulate(row, value[v + k], kernel[k])
                _accumulate(row_certainty, certainty[v + k], kernel[k])
            target = out[i, v]
            total = np.zeros(width, np.float32)
            target[:] = np.float32(0.0)
            for k in range(kernel.size):
                _accumulate(target, row[k : k + width], kernel[k])
                _accumulate(total, row_certainty[k : k + width], kernel[k])
            for u in range(width):
                f = images[i, v, u]
                target[u] = target[u] / total[u] if f == f else f
