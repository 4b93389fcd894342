"""Between the four trees of a two-dimensional sub-band and its two complex orientations.

A real sub-band of the interleaved trees holds quads ``a b / c d`` (row tree, column tree). Two
complex coefficients, of mirrored orientations, are

    z₁ = ((a − d) + i (b + c)) / √2,    z₂ = ((a + d) + i (b − c)) / √2

an orthonormal change of basis. Transposing the sub-band exchanges b and c, which conjugates z₂
and leaves both magnitudes alone: shrinkage need not know how a sub-band lies.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

Image: TypeAlias = NDArray[np.float32]
Complex: TypeAlias = NDArray[np.complex64]

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}
_TINY = np.float32(1e-30)
_HALF = np.float32(0.5)


def to_complex(band: Image) -> tuple[Complex, Complex]:
    """z₁ and z₂, each (H, W), of a real sub-band (2H, 2W)."""
    a, b = band[0::2, 0::2], band[0::2, 1::2]
    c, d = band[1::2, 0::2], band[1::2, 1::2]
    scale = np.complex64(np.sqrt(0.5))
    return scale * ((a - d) + 1j * (b + c)), scale * ((a + d) + 1j * (b - c))


def to_real(z1: Complex, z2: Complex) -> Image:
    """Real sub-band (2H, 2W) of z₁ and z₂: the inverse of `to_complex`."""
    scale = np.float32(np.sqrt(0.5))
    band = np.empty((2 * z1.shape[0], 2 * z1.shape[1]), dtype=np.float32)
    band[0::2, 0::2] = scale * (z2.real + z1.real)
    band[1::2, 1::2] = scale * (z2.real - z1.real)
    band[0::2, 1::2] = scale * (z1.imag + z2.imag)
    band[1::2, 0::2] = scale * (z1.imag - z2.imag)
    return band


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def magnitudes(band: Image) -> tuple[Image, Image]:
    """|z₁| and |z₂|, each (H, W), of a real sub-band (2H, 2W)."""
    rows, cols = band.shape[0] // 2, band.shape[1] // 2
    first = np.empty((rows, cols), dtype=np.float32)
    second = np.empty((rows, cols), dtype=np.float32)
    for r in range(rows):
        top, bottom = band[2 * r], band[2 * r + 1]
        for q in range(cols):
            a, b, c, d = top[2 * q], top[2 * q + 1], bottom[2 * q], bottom[2 * q + 1]
            first[r, q] = np.sqrt(_HALF * ((a - d) * (a - d) + (b + c) * (b + c)))
            second[r, q] = np.sqrt(_HALF * ((a + d) * (a + d) + (b - c) * (b - c)))
    return first, second


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def soft(band: Image, threshold: Image) -> float:
    """Soft thresholding of |z₁| and |z₂| in place (eq. 3.5); returns the mean squared gain.

    Parameters
    ----------
    band : (2H, 2W) float32
        Real sub-band, overwritten.
    threshold : (H, W) float32
        T ≥ 0 of each quad.

    Returns
    -------
    float
        Mean of (|w_new| / |w|)², 0 … 1.
    """
    rows, cols = band.shape[0] // 2, band.shape[1] // 2
    kept = 0.0
    for r in range(rows):
        top, bottom, T = band[2 * r], band[2 * r + 1], threshold[r]
        line = 0.0
        for q in range(cols):
            a, b, c, d = top[2 * q], top[2 * q + 1], bottom[2 * q], bottom[2 * q + 1]
            x1, y1, x2, y2 = a - d, b + c, a + d, b - c
            m1 = np.sqrt(_HALF * (x1 * x1 + y1 * y1))
            m2 = np.sqrt(_HALF * (x2 * x2 + y2 * y2))
            g1 = max(m1 - T[q], np.float32(0.0)) / max(m1, _TINY)
            g2 = max(m2 - T[q], np.float32(0.0)) / max(m2, _TINY)
            top[2 * q] = _HALF * (g2 * x2 + g1 * x1)
            bottom[2 * q + 1] = _HALF * (g2 * x2 - g1 * x1)
            top[2 * q + 1] = _HALF * (g1 * y1 + g2 * y2)
            bottom[2 * q] = _HALF * (g1 * y1 - g2 * y2)
            line += g1 * g1 + g2 * g2
        kept += line
    return kept / max(2 * rows * cols, 1)


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def wiener(band: Image, pilot: Image, noise: Image) -> float:
    """Wiener's gain |x|² / (|x|² + 2σ²) on z₁ and z₂ in place; returns the mean squared gain.

    Parameters
    ----------
    band, pilot : (2H, 2W) float32
        Real sub-bands: to be shrunk, and of the pilot x.
    noise : (H, W) float32
        σ of each real part.

    Returns
    -------
    float
        0 … 1.
    """
    rows, cols = band.shape[0] // 2, band.shape[1] // 2
    kept = 0.0
    for r in range(rows):
        top, bottom, s = band[2 * r], band[2 * r + 1], noise[r]
        p_top, p_bottom = pilot[2 * r], pilot[2 * r + 1]
        line = np.float32(0.0)
        for q in range(cols):
            a, b, c, d = p_top[2 * q], p_top[2 * q + 1], p_bottom[2 * q], p_bottom[2 * q + 1]
            e1 = _HALF * ((a - d) * (a - d) + (b + c) * (b + c))
            e2 = _HALF * ((a + d) * (a + d) + (b - c) * (b - c))
            n = max(s[q] * s[q] + s[q] * s[q], _TINY)
            g1, g2 = e1 / (e1 + n), e2 / (e2 + n)
            a, b, c, d = top[2 * q], top[2 * q + 1], bottom[2 * q], bottom[2 * q + 1]
            x1, y1, x2, y2 = g1 * (a - d), g1 * (b + c), g2 * (a + d), g2 * (b - c)
            top[2 * q], bottom[2 * q + 1] = _HALF * (x2 + x1), _HALF * (x2 - x1)
            top[2 * q + 1], bottom[2 * q] = _HALF * (y1 + y2), _HALF * (y1 - y2)
            line += g1 * g1 + g2 * g2
        kept += float(line)
    return kept / max(2 * rows * cols, 1)


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def scale(band: Image, gain1: Image, gain2: Image) -> None:
    """Multiply z₁ and z₂ by real gains (H, W), in place."""
    for r in range(band.shape[0] // 2):
        top, bottom = band[2 * r], band[2 * r + 1]
        for q in range(band.shape[1] // 2):
            a, b, c, d = top[2 * q], top[2 * q + 1], bottom[2 * q], bottom[2 * q + 1]
            g1, g2 = gain1[r, q], gain2[r, q]
            x1, y1, x2, y2 = g1 * (a - d), g1 * (b + c), g2 * (a + d), g2 * (b - c)
            top[2 * q], bottom[2 * q + 1] = _HALF * (x2 + x1), _HALF * (x2 - x1)
            top[2 * q + 1], bottom[2 * q] = _HALF * (y1 + y2), _HALF * (y1 - y2)
