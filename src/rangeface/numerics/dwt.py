"""The discrete wavelet transform of images, as banded matrices; any wavelet of PyWavelets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
import pywt
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import banded
from rangeface.numerics.banded import Banded

Image: TypeAlias = NDArray[np.float32]
Bands: TypeAlias = tuple[Image, Image, Image]


@dataclass(eq=False)
class Decomposition:
    """Coefficients of an image.

    Parameters
    ----------
    shape : tuple of int
        Of the image.
    wavelet : str
        Its PyWavelets name.
    lowpass : (H', W') float32
        What the coarsest level leaves.
    details : list of (lh, hl, hh)
        Per level, finest first; first letter vertical, second horizontal (PyWavelets names them
        the other way round: lh is its "vertical detail"). Levels 1, 3, … lie transposed, and so
        does the low-pass after an odd number of levels: `banded.split` leaves them so.
    """

    shape: tuple[int, int]
    wavelet: str
    lowpass: Image
    details: list[Bands]


@lru_cache(maxsize=64)
def check(levels: int, wavelet: str) -> None:
    """Refuse a level count or a wavelet that does not exist.

    Raises
    ------
    ParameterError
        `levels` < 1, or PyWavelets knows no discrete wavelet of this name.
    """
    if levels < 1:
        raise ParameterError(f"levels must be ≥ 1, got {levels}")
    if wavelet not in pywt.wavelist(kind="discrete"):
        raise ParameterError(f"wavelet: PyWavelets has no discrete wavelet {wavelet!r}")


def forward(image: ArrayLike, *, wavelet: str = "db4", levels: int = 4) -> Decomposition:
    """Wavelet transform of a finite image, half-sample symmetric at the border.

    Parameters
    ----------
    image : (H, W) array_like
        Finite.
    wavelet : str
        Any discrete wavelet of PyWavelets.
    levels : int
        ≥ 1.

    Returns
    -------
    Decomposition

    Raises
    ------
    ParameterError
        `levels` < 1, or an unknown wavelet.

    References
    ----------
    S. Mallat, IEEE TPAMI 11(7), 1989, doi:10.1109/34.192463.

    Examples
    --------
    >>> bands = forward(np.ones((8, 8)), wavelet="haar", levels=2)
    >>> bands.lowpass.round(4)
    array([[4., 4.],
           [4., 4.]], dtype=float32)
    """
    check(levels, wavelet)
    x = np.ascontiguousarray(image, dtype=np.float32)
    shape = (x.shape[0], x.shape[1])
    details: list[Bands] = []
    for _ in range(levels):
        down, along = (_analysis(wavelet, n) for n in x.shape)
        x, lh, hl, hh = banded.split(x, *down, *along)
        details.append((lh, hl, hh))
    return Decomposition(shape, wavelet, x, details)


def inverse(bands: Decomposition) -> Image:
    """The image of its coefficients: the inverse of `forward`."""
    x = bands.lowpass
    sizes = _sizes(bands.shape, bands.wavelet, len(bands.details))
    for size, detail in zip(reversed(sizes), reversed(bands.details), strict=True):
        down, along = (_synthesis(bands.wavelet, n) for n in size)
        x = banded.merge(x, *detail, *down, *along)
    return x


@lru_cache(maxsize=32)
def noise_gains(levels: int, wavelet: str) -> list[tuple[float, float]]:
    """Standard deviation of white unit noise, per level: sides, diagonal (1 if orthonormal)."""
    length = n = 2 * len(_filters(wavelet)[0]) << levels
    matrices = []
    for _ in range(levels):
        low, high = _analysis(wavelet, n)
        matrices.append((low, high))
        n = len(low.start) - 1
    return banded.noise_gains(matrices, length)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def soft(band: Image, threshold: Image) -> float:
    """Soft thresholding in place (eq. 3.5); returns the mean squared gain, 0 … 1."""
    kept = 0.0
    for r in range(band.shape[0]):
        line, T = band[r], threshold[r]
        total = 0.0
        for c in range(band.shape[1]):
            magnitude = abs(line[c])
            gain = max(magnitude - T[c], np.float32(0.0)) / max(magnitude, np.float32(1e-30))
            line[c] *= gain
            total += gain * gain
        kept += total
    return kept / max(band.size, 1)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def wiener(band: Image, pilot: Image, noise: Image) -> float:
    """Wiener's gain x² / (x² + σ²) in place, x from a pilot; returns the mean squared gain."""
    kept = 0.0
    for r in range(band.shape[0]):
        line, x, s = band[r], pilot[r], noise[r]
        total = 0.0
        for c in range(band.shape[1]):
            energy = x[c] * x[c]
            gain = energy / (energy + max(s[c] * s[c], np.float32(1e-30)))
            line[c] *= gain
            total += gain * gain
        kept += total
    return kept / max(band.size, 1)


@lru_cache(maxsize=16)
def _filters(wavelet: str) -> list[NDArray[np.float64]]:
    return [np.asarray(taps) for taps in pywt.Wavelet(wavelet).filter_bank]


@lru_cache(maxsize=64)
def _analysis(wavelet: str, length: int) -> tuple[Banded, Banded]:
    """Low- and high-pass: row n holds h[k] at 2n + 1 − k of the mirrored signal."""
    low, high, _, _ = _filters(wavelet)
    rows = (length + len(low) - 1) // 2
    n, k = np.mgrid[:rows, : len(low)]
    folded = np.mod(2 * n + 1 - k, 2 * length)
    columns = np.where(folded < length, folded, 2 * length - 1 - folded)

    def matrix(taps: NDArray[np.float64]) -> Banded:
        return banded.banded(n, columns, np.broadcast_to(taps, n.shape), (rows, length))

    return matrix(low), matrix(high)


@lru_cache(maxsize=64)
def _synthesis(wavelet: str, length: int) -> tuple[Banded, Banded]:
    """Low- and high-pass back to `length`: coefficient n adds g[k] at 2n + k − m + 2."""
    _, _, low, high = _filters(wavelet)
    count = (length + len(low) - 1) // 2
    n, k = np.mgrid[:count, : len(low)]
    rows = 2 * n + k - len(low) + 2
    inside = (rows >= 0) & (rows < length)

    def matrix(taps: NDArray[np.float64]) -> Banded:
        weights = np.broadcast_to(taps, n.shape)
        return banded.banded(rows[inside], n[inside], weights[inside], (length, count))

    return matrix(low), matrix(high)


@lru_cache(maxsize=64)
def _sizes(shape: tuple[int, int], wavelet: str, levels: int) -> list[tuple[int, int]]:
    """Size that enters each level, transposed with it."""
    taps = len(_filters(wavelet)[0])
    sizes = [shape]
    for _ in range(1, levels):
        rows, cols = ((n + taps - 1) // 2 for n in sizes[-1])
        sizes.append((cols, rows))
    return sizes
