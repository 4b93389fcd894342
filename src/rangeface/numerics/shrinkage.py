"""How much of a wavelet coefficient is signal.

Every rule here speaks of normalised coefficients: divided by the standard deviation of the
noise in them (of each real part, for complex ones).
"""

from __future__ import annotations

from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

Image: TypeAlias = NDArray[np.float32]

# no coefficient survives this threshold
_EVERYTHING = 1e6


def bayes_threshold(energy: float) -> float:
    r"""BayesShrink's threshold of a sub-band, in units of the noise.

    .. math:: T = \frac{σ_n^2}{σ_x}, \qquad σ_x^2 = \max(σ_y^2 - σ_n^2, 0)

    Parameters
    ----------
    energy : float
        Mean square of the normalised coefficients, σ_y² / σ_n².

    Returns
    -------
    float
        T / σ_n; where the sub-band holds no more than noise, a threshold that removes it.

    References
    ----------
    S. G. Chang, B. Yu, M. Vetterli, IEEE Trans. Image Process. 9(9), 2000,
    doi:10.1109/83.862633.

    Examples
    --------
    >>> bayes_threshold(5.0), bayes_threshold(0.9)
    (0.5, 1000000.0)
    """
    signal = energy - 1.0
    return signal**-0.5 if signal > 1.0 / _EVERYTHING**2 else _EVERYTHING


def bivariate_gain(magnitude: Image, parent: Image | None, parts: int, window_px: int) -> Image:
    r"""Gain of the bivariate shrinkage, which looks at a coefficient and at its parent.

    .. math:: g = \max\!\left(0,\; 1 - \frac{\sqrt{3}\, σ_n^2}{σ \sqrt{|y_1|^2 + |y_2|^2}}\right),
              \qquad σ^2 = \max(\overline{|y_1|^2} / p - σ_n^2, 0)

    Parameters
    ----------
    magnitude : (H, W) float32
        |y₁| of the normalised coefficients.
    parent : (H, W) float32, optional
        |y₂| at the same places of the next coarser level, normalised by its own noise. At the
        coarsest level, which has none, the univariate rule (√2 for √3, y₂ = 0) is used.
    parts : int
        p: 1 for real, 2 for complex coefficients.
    window_px : int
        Edge of the window of the local mean.

    Returns
    -------
    (H, W) float32
        0 … 1.

    References
    ----------
    L. Sendur, I. W. Selesnick, IEEE Signal Process. Lett. 9(12), 2002, doi:10.1109/LSP.2002.806054.

    Examples
    --------
    >>> strong = np.full((9, 9), 10.0, np.float32)
    >>> round(float(bivariate_gain(strong, strong, 1, 7)[4, 4]), 4)
    0.9877
    """
    energy = magnitude * magnitude

    local = cv2.blur(energy, (window_px, window_px), borderType=cv2.BORDER_REFLECT)
    signal = np.sqrt(np.maximum(local / np.float32(parts) - 1.0, 1e-12))
    if parent is None:
        return np.maximum(0.0, 1.0 - np.sqrt(2.0, dtype=np.float32) / _floor(signal * magnitude))
    pair = np.sqrt(energy + parent * parent)
    return np.maximum(0.0, 1.0 - np.sqrt(3.0, dtype=np.float32) / _floor(signal * pair))


def _floor(values: Image) -> Image:
    return np.maximum(values, np.float32(1e-12))
