from __future__ import annotations

import cv2
import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._noise import sigma_map
from rangeface.numerics import holes
from rangeface.types import Float32, RangeImage


def non_local_means(
    image: RangeImage, *, strength: float = 1.0, patch_px: int = 5, search_px: int = 13
) -> RangeImage:
    r"""Non-local means: average over pixels whose surroundings look alike.

    .. math:: w_{pq} = \exp\!\left(-\frac{\max(\overline{(P_p - P_q)^2} - 2σ^2, 0)}{h^2}\right),
              \qquad h = kσ

    Parameters
    ----------
    image : RangeImage
        Any image; holes stay holes.
    strength : float
        k > 0.
    patch_px, search_px : int
        Edges of the patch P and of the window that is searched, odd, ≥ 3 px.

    Returns
    -------
    RangeImage
        σ as it was, an upper bound: the gain depends on the scene.

    Raises
    ------
    ParameterError
        The strength is not positive, or an edge is even or < 3.

    References
    ----------
    A. Buades, B. Coll, J.-M. Morel, CVPR 2005, doi:10.1109/CVPR.2005.38.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    >>> image = RangeImage(500.0 + noise, Orthographic(2.8, 24.5, 39.5, 50, 80))
    >>> bool(np.std(non_local_means(image).depth) < 1.0)
    True
    """
    _check.positive("strength", strength)
    _check.odd("patch_px", patch_px)
    _check.odd("search_px", search_px)
    if not image.mask.any():
        return image
    sigma = float(np.median(sigma_map(image)[image.mask]))
    if sigma <= 0.0:
        return image
    level = np.float32(np.nanmedian(image.depth))
    reach = search_px // 2
    plane = holes.extended(image.depth - level, image.mask)
    wide = cv2.copyMakeBorder(plane, reach, reach, reach, reach, cv2.BORDER_REFLECT)
    out = _weighted_mean(
        wide, image.shape, reach, patch_px, 2.0 * sigma**2, (strength * sigma) ** 2
    )
    return image.with_depth(np.where(image.mask, out + level, np.nan))


def _weighted_mean(
    wide: Float32,
    shape: tuple[int, int],
    reach: int,
    patch_px: int,
    bias: float,
    bandwidth: float,
) -> Float32:
    rows, cols = shape
    centre = wide[reach : reach + rows, reach : reach + cols]
    total = np.zeros(shape, dtype=np.float32)
    weights = np.zeros(shape, dtype=np.float32)
    for dy in range(2 * reach + 1):
        for dx in range(2 * reach + 1):
            other = wide[dy : dy + rows, dx : dx + cols]
            distance = cv2.blur((centre - other) ** 2, (patch_px, patch_px))
            weight = np.exp(-np.maximum(distance - np.float32(bias), 0) / np.float32(bandwidth))
            total += weight * other
            weights += weight
    return total / weights
