from __future__ import annotations

from functools import partial

from rangeface.denoise import _wavelet
from rangeface.denoise._wavelet import Rule, Rules, Transform
from rangeface.numerics.dtcwt import quads, trees
from rangeface.types import RangeImage


def dtcwt(
    image: RangeImage,
    *,
    shrinkage: Rule = "wiener",
    threshold_sigma: float = 2.0,
    threshold_mm: float | None = None,
    per_pixel_sigma: bool = True,
    levels: int = 4,
    first: str = "near_sym_a",
    further: str = "qshift_06",
) -> RangeImage:
    r"""Shrink the coefficients of the dual-tree complex wavelet transform.

    With ``shrinkage="soft"``, eq. 3.5 on the complex magnitude:

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
        Multiple of the noise in a coefficient's real part, ≥ 0; for "soft".
    threshold_mm : float, optional
        One fixed T for all coefficients, ≥ 0, instead of any rule; 0 changes nothing.
    per_pixel_sigma : bool
        Follow the sensor's σ from pixel to pixel; False takes its median. Where the image has
        no σ it is estimated, one for all pixels.
    levels : int
        ≥ 1.
    first, further : str
        Filters, see `rangeface.numerics.dtcwt.forward_2d`.

    Returns
    -------
    RangeImage
        σ is scaled by the root of the noise energy that the shrinkage left on average.

    Raises
    ------
    ParameterError
        An unknown rule or filter, a negative threshold, or `levels` < 1.

    Notes
    -----
    σ of a coefficient is the local root mean of σ² times the sub-band's gain for white noise.
    Where σ varies slowly this equals dividing by σ, denoising and multiplying back, without
    imprinting the texture of σ on a depth of hundreds of mm.

    References
    ----------
    I. W. Selesnick, R. G. Baraniuk, N. G. Kingsbury, 2005, doi:10.1109/MSP.2005.1550194;
    L. Sendur, I. W. Selesnick, 2002, doi:10.1109/LSP.2002.806054; S. P. Ghael, A. M. Sayeed,
    R. G. Baraniuk, 1997, doi:10.1117/12.292799.

    Examples
    --------
    >>> import numpy as np
    >>> from rangeface.types import Orthographic
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    >>> image = RangeImage(500.0 + noise, Orthographic(2.8, 24.5, 39.5, 50, 80))
    >>> bool(np.std(dtcwt(image).depth) < 0.5)
    True
    """
    rules = Rules(shrinkage, threshold_sigma, threshold_mm, per_pixel_sigma)
    _wavelet.check(rules)
    trees.check(levels, first, further)
    transform = Transform(
        analyse=partial(trees.analyse, levels=levels, first=first, further=further),
        synthesise=trees.synthesise,
        gains=trees.noise_gains(levels, first, further),
        stride=2,
        parts=2,
        magnitudes=quads.magnitudes,
        soft=quads.soft,
        wiener=quads.wiener,
        scale=quads.scale,
    )
    return _wavelet.denoise(image, transform, rules)
