from __future__ import annotations

import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._confidence import amplitude_of
from rangeface.numerics import smoothing
from rangeface.types import RangeImage


def guided(image: RangeImage, *, radius_px: int = 2, smoothness: float = 0.1) -> RangeImage:
    r"""Guided filter: depth as a locally linear function of the (logarithmic) amplitude.

    .. math:: z' = \bar a\, I + \bar b, \qquad b = \bar z - a \bar I, \qquad
              a = \frac{\operatorname{cov}(I, z)}{\operatorname{var} I + ε}

    with all means over windows and over valid pixels only, and I = ln A in units of its own
    standard deviation.

    Parameters
    ----------
    image : RangeImage
        Any image; holes stay holes. Without an amplitude the depth guides itself.
    radius_px : int
        Half the window, px, ≥ 1.
    smoothness : float
        ε > 0, relative to the variance of the guide.

    Returns
    -------
    RangeImage
        σ as it was, an upper bound: the gain depends on the scene.

    Raises
    ------
    ParameterError
        A parameter is not positive.

    Notes
    -----
    The amplitude's own texture (brows, lips, beard) is written into the depth wherever it goes
    with depth nearby. Use it where light is strong and depth weak.

    References
    ----------
    K. He, J. Sun, X. Tang, IEEE TPAMI 35(6), 2013, doi:10.1109/TPAMI.2012.213.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    >>> camera = Orthographic(2.8, 24.5, 39.5, 50, 80)
    >>> image = RangeImage(500.0 + noise, camera, amplitude=np.full((80, 50), 90.0))
    >>> bool(np.std(guided(image).depth) < 1.0)
    True
    """
    _check.positive("radius_px", radius_px)
    _check.positive("smoothness", smoothness)
    if not image.mask.any():
        return image
    level = np.float32(np.nanmedian(image.depth))
    guide = image.depth - level
    if image.amplitude is not None:
        guide = np.log(np.maximum(amplitude_of(image), np.float32(1e-6)))
    guide = np.where(image.mask, guide - np.mean(guide[image.mask]), np.float32(0))
    spread = float(np.std(guide[image.mask]))
    out = smoothing.guided(
        np.where(image.mask, image.depth - level, np.float32(0)),
        guide / np.float32(spread if spread > 0 else 1.0),
        image.mask,
        int(radius_px),
        smoothness,
    )
    return image.with_depth(np.where(image.mask, out + level, np.nan))
