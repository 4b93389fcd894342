"""Gabor wavelets."""

from __future__ import annotations

from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.fft import fft2, fftfreq, ifft2, next_fast_len

from rangeface.errors import ParameterError

Float32: TypeAlias = NDArray[np.float32]
Float64: TypeAlias = NDArray[np.float64]


def magnitudes(images: ArrayLike, *, scales: int = 3, orientations: int = 4) -> Float32:
    r"""Magnitudes of the responses to a bank of Gabor wavelets.

    .. math:: ψ_k(x) = \frac{|k|^2}{σ^2} e^{-|k|^2 |x|^2 / 2σ^2}
              \bigl(e^{i k·x} - e^{-σ^2/2}\bigr), \qquad
              |k| = \frac{π}{2} 2^{-ν/2}, \quad σ = 2π

    Parameters
    ----------
    images : (…, H, W) array_like
        Finite values.
    scales : int
        Number of wave lengths: 4, 5.7, 8, … px; 1 … 5.
    orientations : int
        Number of directions, equally spaced over 180°, 1 … 16.

    Returns
    -------
    (…, H, W, scales · orientations) float32
        ≥ 0, scale by scale.

    Raises
    ------
    ParameterError
        A number is out of range, or a value is not finite.

    Notes
    -----
    Applied in the frequency domain to the image continued by reflection. The second term makes
    the wavelet blind to a constant.

    References
    ----------
    C. Liu, H. Wechsler, IEEE TIP 11(4), 2002, doi:10.1109/TIP.2002.999679, eq. 1–2 (with
    f = √2).

    Examples
    --------
    >>> waves = np.tile(np.cos(np.arange(32) * np.pi / 2), (32, 1))
    >>> int(magnitudes(waves)[16, 16].argmax())  # first scale, first direction
    0
    """
    f = np.asarray(images, np.float64)
    if not 1 <= scales <= 5:
        raise ParameterError(f"scales: must be 1 … 5, got {scales}")
    if not 1 <= orientations <= 16:
        raise ParameterError(f"orientations: must be 1 … 16, got {orientations}")
    if f.ndim < 2 or not np.isfinite(f).all():
        raise ParameterError("images: expected finite (…, H, W)")
    height, width = f.shape[-2:]
    shape = (next_fast_len(2 * height), next_fast_len(2 * width))
    frame = [(0, 0)] * (f.ndim - 2) + [(0, shape[0] - height), (0, shape[1] - width)]
    spectrum = fft2(np.pad(f - f.mean(axis=(-2, -1), keepdims=True), frame, mode="symmetric"))
    bank = _bank(shape, scales, orientations)
    out = np.empty((*f.shape, len(bank)), np.float32)
    for channel, response in enumerate(bank):
        out[..., channel] = np.abs(ifft2(spectrum * response))[..., :height, :width]
    return out


@lru_cache(maxsize=8)
def _bank(shape: tuple[int, int], scales: int, orientations: int) -> Float64:
    """Transfer functions (scales · orientations, rows, columns), unit peak."""
    wy, wx = np.meshgrid(*(2.0 * np.pi * fftfreq(n) for n in shape), indexing="ij")
    σ = 2.0 * np.pi
    bank = []
    for scale in range(scales):
        k = 0.5 * np.pi * 2.0 ** (-scale / 2.0)
        for direction in range(orientations):
            angle = np.pi * direction / orientations
            kx, ky = k * np.cos(angle), k * np.sin(angle)
            spread = σ * σ / (2.0 * k * k)
            wave = np.exp(-spread * ((wx - kx) ** 2 + (wy - ky) ** 2))
            mean = np.exp(-spread * (wx**2 + wy**2) - 0.5 * σ * σ)
            bank.append(wave - mean)
    return np.stack(bank)
