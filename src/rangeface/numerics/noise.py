"""How noisy an image is, by looking at it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

# quartiles of |x| for a standard normal x
_MEDIAN = 0.6744897501960817
_UPPER_QUARTILE = 1.1503493803760083


def estimate_sigma(values: ArrayLike) -> float:
    r"""Standard deviation of white noise on a smooth image with holes.

    .. math:: \hat σ = \frac{\operatorname{median} |a - b - c + d| / 2}{0.6745}

    over all 2 × 2 blocks of valid pixels: the diagonal Haar detail, which no plane excites.

    Parameters
    ----------
    values : (H, W) array_like
        NaN = invalid.

    Returns
    -------
    float
        Same unit as the values; NaN where no 2 × 2 block is valid.

    Notes
    -----
    Coarsely rounded depth shows details of zero or of one step only. Where the median is zero,
    the upper quartile (1.15 σ) is read instead; where that is zero too, the image is taken to
    be free of noise.

    References
    ----------
    D. L. Donoho, I. M. Johnstone, Biometrika 81(3), 1994, doi:10.1093/biomet/81.3.425.

    Examples
    --------
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (144, 176))
    >>> round(estimate_sigma(np.add.outer(np.arange(144.0), np.arange(176.0)) + noise), 1)
    2.0
    """
    z = np.asarray(values, dtype=np.float64)
    detail = 0.5 * np.abs(z[:-1, :-1] - z[:-1, 1:] - z[1:, :-1] + z[1:, 1:])
    detail = detail[np.isfinite(detail)]
    if not detail.size:
        return float("nan")
    median, upper = np.percentile(detail, (50, 75))
    return float(median / _MEDIAN if median > 0.0 else upper / _UPPER_QUARTILE)
