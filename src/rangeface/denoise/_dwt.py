from __future__ import annotations

from functools import partial

import numpy as np

from rangeface.denoise import _wavelet
from rangeface.denoise._wavelet import Rule, Rules, Transform
from rangeface.numerics import dwt as bands
from rangeface.types import Float32, RangeImage


def dwt(
    image: RangeImage,
    *,
    shrinkage: Rule = "soft",
    threshold_sigma: float = 2.0,
    threshold_mm: float | None = None,
    per_pixel_sigma: bool = True,
    levels: int = 4,
    wavelet: str = "db4",
) -> RangeImage:
    r"""Shrink the coefficients of the discrete wavelet transform.

    With ``shrinkage="soft"``, eq. 3.5 over all scales and sub-bands:

    .. math:: w_{new} = \frac{\max(|w| - T, 0)}{|w|}\, w

    Parameters
    ----------
    image : RangeImage
        Any image; holes stay holes.
    shrinkage : str
        "soft": T = `threshold_sigma` · σ. "bayes": T = σ²/σ_signal, per sub-band. "bivariate":
        each coefficient judged with its parent and its neighbours. "wiener": that as a pilot,
        then Wiener's gain twice, each time with the signal as known so far.
    threshold_sigma : float
        Multiple of the noise in a coefficient, ≥ 0; for "soft".
    threshold_mm : float, optional
        One fixed T for all coefficients, ≥ 0, instead of any rule; 0 changes nothing.
    per_pixel_sigma : bool
        Follow the sensor's σ from pixel to pixel; False takes its median. Where the image has
        no σ it is estimated, one for all pixels.
    levels : int
        ≥ 1.
    wavelet : str
        Any discrete wavelet of PyWavelets.

    Returns
    -------
    RangeImage
        σ is scaled by the root of the noise energy that the shrinkage left on average.

    Raises
    ------
    ParameterError
        An unknown rule or wavelet, a negative threshold, or `levels` < 1.

    References
    ----------
    D. L. Donoho, IEEE Trans. Inf. Theory 41(3), 1995, doi:10.1109/18.382009.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    >>> image = RangeImage(500.0 + noise, Orthographic(2.8, 24.5, 39.5, 50, 80))
    >>> bool(np.std(dwt(image).depth) < 1.0)
    True
    """
    rules = Rules(shrinkage, threshold_sigma, threshold_mm, per_pixel_sigma)
    _wavelet.check(rules)
    bands.check(levels, wavelet)
    transform = Transform(
        analyse=partial(bands.forward, wavelet=wavelet, levels=levels),
        synthesise=bands.inverse,
        gains=bands.noise_gains(levels, wavelet),
        stride=1,
        parts=1,
        magnitudes=_magnitudes,
        soft=bands.soft,
        wiener=bands.wiener,
        scale=_scale,
    )
    return _wavelet.denoise(image, transform, rules)


def _magnitudes(band: Float32) -> tuple[Float32, ...]:
    return (np.abs(band),)


def _scale(band: Float32, gain: Float32) -> None:
    band *= gain
