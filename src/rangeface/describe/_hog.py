"""Histograms of oriented gradients of the relief."""

from __future__ import annotations

from rangeface.describe._frontal import pitch_of
from rangeface.numerics import hog as oriented
from rangeface.numerics import localfit
from rangeface.types import Float32, RangeImage


def hog(
    image: RangeImage,
    *,
    cell_px: int = 8,
    block_cells: int = 2,
    bins: int = 9,
    radius_px: float = 1.5,
) -> Float32:
    """Histograms of oriented gradients of the relief.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    cell_px : int
        Edge of a cell, px, ≥ 2.
    block_cells : int
        Edge of a block, cells, ≥ 1.
    bins : int
        Number of orientations over 180°, ≥ 2.
    radius_px : float
        Radius of the plane fit that gives the slopes, px, 1 … 15.

    Returns
    -------
    (n,) float32
        0 … 1. Holes do not vote.

    Raises
    ------
    ParameterError
        The image is not frontal, a parameter is out of range, or no block fits.
    DegenerateError
        The image has no valid pixel.

    References
    ----------
    N. Dalal, B. Triggs, CVPR 2005, doi:10.1109/CVPR.2005.177.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> import numpy as np
    >>> hog(RangeImage(np.zeros((80, 50)), Orthographic(2.8, 25, 40, 50, 80))).shape
    (1620,)
    """
    pitch_mm = pitch_of(image)
    slopes = localfit.fit(-image.depth, radius_px=radius_px, degree=1)[..., 1:] / pitch_mm
    return oriented.hog(
        slopes[..., 0], slopes[..., 1], cell_px=cell_px, block_cells=block_cells, bins=bins
    )
