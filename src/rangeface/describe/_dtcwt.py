"""Magnitudes of the dual-tree complex wavelet transform of the relief."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import pitch_of
from rangeface.errors import ParameterError
from rangeface.numerics import dtcwt as tree
from rangeface.numerics import holes
from rangeface.types import Float32, RangeImage


def dtcwt(image: RangeImage, *, levels: tuple[int, ...] = (2, 3)) -> Float32:
    """Magnitudes of the relief's dual-tree complex wavelet coefficients.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    levels : tuple of int
        Which levels, each 1 … 6; level k has details of about 2^k pixels. The first holds mostly
        noise.

    Returns
    -------
    (n,) float32
        mm, ≥ 0: level by level, six directions each, rows and columns halved with every level.
        Magnitudes change little when the face shifts by a fraction of their cell. Holes have the
        mean depth before the transform.

    Raises
    ------
    ParameterError
        The image is not frontal, or a level is out of range.
    DegenerateError
        The image has no valid pixel.

    References
    ----------
    I. W. Selesnick, R. G. Baraniuk, N. G. Kingsbury, IEEE Signal Processing Magazine 22(6), 2005,
    doi:10.1109/MSP.2005.1550194.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.ones((80, 50)), Orthographic(2.8, 25, 40, 50, 80))
    >>> dtcwt(flat).shape
    (1980,)
    """
    pitch_of(image)
    if not levels or any(level not in range(1, 7) for level in levels):
        raise ParameterError(f"levels: must be a choice of 1 … 6, got {levels}")
    relief = holes.fill_mean(-image.depth)
    pyramid = tree.forward_2d(relief, levels=max(levels))
    return np.concatenate([np.abs(pyramid.highpasses[level - 1]).ravel() for level in levels])
