from __future__ import annotations

import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._noise import sigma_map
from rangeface.errors import ParameterError
from rangeface.numerics import smoothing
from rangeface.types import RangeImage


def total_variation(
    image: RangeImage, *, strength: float = 1.0, iterations: int = 60
) -> RangeImage:
    r"""Total-variation denoising, noise-weighted, with free edges at holes.

    .. math:: \min_u \sum_p \frac{(u_p - z_p)^2}{2 σ_p} + k \sum_p \|\nabla u_p\|

    Parameters
    ----------
    image : RangeImage
        Any image; holes stay holes.
    strength : float
        k ≥ 0; 0 changes nothing. λ = kσ balances the two terms for noise of size σ.
    iterations : int
        Of the dual projection, ≥ 1.

    Returns
    -------
    RangeImage
        σ as it was, an upper bound: the gain depends on the scene.

    Raises
    ------
    ParameterError
        The strength is negative, or there is no iteration.

    Notes
    -----
    Its staircases are planes of equal depth: surface normals suffer.

    References
    ----------
    L. I. Rudin, S. Osher, E. Fatemi, Physica D 60, 1992, doi:10.1016/0167-2789(92)90242-F;
    A. Chambolle, J. Math. Imaging Vis. 20, 2004, doi:10.1023/B:JMIV.0000011325.36760.1e.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    >>> image = RangeImage(500.0 + noise, Orthographic(2.8, 24.5, 39.5, 50, 80))
    >>> bool(np.std(total_variation(image).depth) < 1.0)
    True
    """
    _check.not_negative("strength", strength)
    if iterations < 1:
        raise ParameterError(f"iterations must be ≥ 1, got {iterations}")
    if not image.mask.any() or strength == 0.0:
        return image
    level = np.float32(np.nanmedian(image.depth))
    weight = np.float32(strength) * sigma_map(image)
    out = smoothing.total_variation(image.depth - level, image.mask, weight, iterations)
    return image.with_depth(np.where(image.mask, out + level, np.nan))
