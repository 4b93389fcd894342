from __future__ import annotations

import cv2
import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._noise import sigma_map
from rangeface.numerics import holes
from rangeface.types import RangeImage


def bilateral(image: RangeImage, *, sigma_px: float = 1.5, range_factor: float = 3.0) -> RangeImage:
    r"""Bilateral filter: weights fall with distance in the image and in depth.

    .. math:: w_{pq} = \exp\!\left(-\frac{\|p - q\|^2}{2 σ_s^2}
                                  - \frac{(z_p - z_q)^2}{2 (kσ)^2}\right)

    Parameters
    ----------
    image : RangeImage
        Any image; holes stay holes.
    sigma_px : float
        σ_s, px, > 0.
    range_factor : float
        k > 0, in units of the noise: its median, or its estimate.

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
    OpenCV's filter; holes are first closed by a smooth continuation of what surrounds them.

    References
    ----------
    C. Tomasi, R. Manduchi, ICCV 1998, doi:10.1109/ICCV.1998.710815.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    >>> image = RangeImage(500.0 + noise, Orthographic(2.8, 24.5, 39.5, 50, 80))
    >>> bool(np.std(bilateral(image).depth) < 1.0)
    True
    """
    _check.positive("sigma_px", sigma_px)
    _check.positive("range_factor", range_factor)
    if not image.mask.any():
        return image
    level = np.float32(np.nanmedian(image.depth))
    plane = holes.extended(image.depth - level, image.mask)
    width = range_factor * float(np.median(sigma_map(image)[image.mask]))
    if width <= 0.0:
        return image
    size = 2 * max(1, round(2.0 * sigma_px)) + 1
    out = cv2.bilateralFilter(plane, size, width, sigma_px, borderType=cv2.BORDER_REFLECT)
    return image.with_depth(np.where(image.mask, out + level, np.nan))
