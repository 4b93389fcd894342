from __future__ import annotations

import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._confidence import confidence_of
from rangeface.denoise._noise import sigma_map
from rangeface.numerics import smoothing
from rangeface.types import RangeImage


def moving_least_squares(
    image: RangeImage, *, sigma_px: float = 1.5, max_step_mm: float = 20.0
) -> RangeImage:
    r"""Fit a plane around every pixel, neighbours weighted by distance and 1/σ².

    .. math:: \min_{a, b, c} \sum_q g(q - p)\, C_q\, (z_q - a - b\, Δu - c\, Δv)^2, \qquad z'_p = a

    Parameters
    ----------
    image : RangeImage
        Any image; holes stay holes.
    sigma_px : float
        Standard deviation of g, px, > 0.
    max_step_mm : float
        A neighbour whose depth differs by more (beyond 3√2 σ) belongs to another surface.

    Returns
    -------
    RangeImage
        σ is propagated as in `normalized_convolution`: exact in the middle of a surface, too
        small at its edge.

    Raises
    ------
    ParameterError
        A parameter is not positive.

    Notes
    -----
    Unlike a mean, a plane is not drawn off a slope at the edge of a surface. Fewer than three
    pixels in reach determine no plane: the pixel stays as it is.

    References
    ----------
    D. Levin, Math. Comp. 67, 1998, doi:10.1090/S0025-5718-98-00974-0.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> slope = np.add.outer(np.arange(8.0), 2 * np.arange(9.0)) + 400
    >>> out = moving_least_squares(RangeImage(slope, Orthographic(2.0, 4, 4, 9, 8)))
    >>> bool(np.abs(out.depth - slope).max() < 1e-3)
    True
    """
    _check.positive("sigma_px", sigma_px)
    _check.positive("max_step_mm", max_step_mm)
    noise = sigma_map(image)
    gate = np.float32(max_step_mm) + np.float32(3.0 * np.sqrt(2.0)) * noise
    trust = confidence_of(image, "amplitude_squared")
    if not trust.any():
        return image
    kernel = smoothing.gaussian_kernel(sigma_px)
    depth = smoothing.local_planes(image.depth, trust / trust.max(), gate, kernel)
    sigma = image.sigma
    if sigma is not None:
        # for symmetric neighbours a plane's value at the centre has the variance of their mean
        _, variance, _ = smoothing.gated_convolution(
            image.depth, trust, sigma**2, image.depth, gate, kernel
        )
        if variance is not None:
            sigma = np.where(np.isfinite(variance), np.sqrt(variance), sigma)
    return image.with_depth(depth, sigma=sigma)
