"""3-D local binary patterns of the relief."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from rangeface.describe._frontal import pitch_of
from rangeface.errors import ParameterError
from rangeface.numerics import gaussian, patterns
from rangeface.types import Float32, RangeImage

Layers: TypeAlias = tuple[int, ...]

UNIT_MM = 140.0 / 255.0
"""One grey level of the paper's images (see `depth_levels`), mm."""


def tdlbp(
    image: RangeImage,
    *,
    layers: Layers = (1, 2, 3, 4),
    radius_px: float = 1.0,
    unit_mm: float = UNIT_MM,
    sigma_px: float = 1.0,
) -> Float32:
    """3-D local binary patterns: sign and size of the differences to the eight neighbours.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    layers : tuple of int
        Which layers, each 1 (sign) or 2 … 4 (the bits 4, 2, 1 of the size).
    radius_px : float
        Radius of the circle of neighbours, px, > 0.
    unit_mm : float
        Unit of a difference, mm, > 0; sizes are rounded to it and cut at 7. The default is
        one grey level of the paper, 0.55 mm.
    sigma_px : float
        Gaussian smoothing before the comparison, px, ≥ 0; 0 is the paper's operator.

    Returns
    -------
    (H, W, len(layers)) float32
        Codes 0 … 255. A missing neighbour counts as level with its centre, and a hole has
        the codes of a flat patch: 255 in layer 1, 0 in the others.

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
    A peak of 5 units (101 in binary): all signs negative, bits 4 and 1 set all around:

    >>> from rangeface.types import Orthographic
    >>> peak = RangeImage([[5, 5, 5], [5, 0, 5], [5, 5, 5]], Orthographic(2.0, 1, 1, 3, 3))
    >>> tdlbp(peak, unit_mm=1.0, sigma_px=0)[1, 1, [0, 2]]
    array([0., 0.], dtype=float32)
    """
    pitch_of(image)
    if not layers or any(layer not in (1, 2, 3, 4) for layer in layers):
        raise ParameterError(f"layers: must be a choice of 1, 2, 3, 4, got {layers}")
    if not (np.isfinite(unit_mm) and unit_mm > 0):
        raise ParameterError(f"unit_mm: must be > 0, got {unit_mm}")
    relief = gaussian.smooth(-image.depth, sigma_px)
    codes = patterns.tdlbp(relief, radius_px=radius_px, unit=unit_mm)
    return np.ascontiguousarray(np.moveaxis(codes[[layer - 1 for layer in layers]], 0, -1))
