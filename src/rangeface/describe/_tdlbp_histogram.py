"""Regional histograms of 3-D local binary patterns."""

from __future__ import annotations

import numpy as np

from rangeface.describe._tdlbp import UNIT_MM, Layers, tdlbp
from rangeface.numerics import histograms
from rangeface.types import Float32, RangeImage


def tdlbp_histogram(
    image: RangeImage,
    *,
    layers: Layers = (1, 2, 3, 4),
    regions: tuple[int, int] = (5, 4),
    radius_px: float = 1.0,
    unit_mm: float = UNIT_MM,
    sigma_px: float = 1.0,
) -> Float32:
    """Histograms of the 3-D local binary patterns by region, layer after layer.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    layers, radius_px, unit_mm, sigma_px
        As for `tdlbp`.
    regions : tuple of int
        Rows and columns of the grid of regions.

    Returns
    -------
    (len(layers) · rows · columns · 256,) float32
        0 … 1, every region's histogram summing to 1. Holes are not counted; a region of holes
        has the histogram of the whole face.

    Raises
    ------
    ParameterError
        The image is not frontal or smaller than the neighbourhood, or a parameter is out of
        range.
    DegenerateError
        The image has no valid pixel.

    References
    ----------
    Y. Huang, Y. Wang, T. Tan, BMVC 2006, doi:10.5244/C.20.90.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((10, 8)), Orthographic(2.0, 4, 5, 8, 10))
    >>> tdlbp_histogram(flat, layers=(1,), regions=(1, 1))[255]
    np.float32(1.0)
    """
    codes = tdlbp(image, layers=layers, radius_px=radius_px, unit_mm=unit_mm, sigma_px=sigma_px)
    return np.concatenate(
        [
            histograms.regional(codes[..., layer], image.mask, count=256, regions=regions)
            for layer in range(len(layers))
        ]
    )
