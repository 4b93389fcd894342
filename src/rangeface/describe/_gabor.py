"""Gabor magnitudes of the relief."""

from __future__ import annotations

from rangeface.describe._frontal import pitch_of
from rangeface.numerics import gabor as wavelets
from rangeface.numerics import holes
from rangeface.types import Float32, RangeImage


def gabor(image: RangeImage, *, scales: int = 3, orientations: int = 4) -> Float32:
    """Magnitudes of the relief's Gabor wavelet responses.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    scales : int
        Number of wave lengths 4, 5.7, 8, … px, 1 … 5.
    orientations : int
        Number of directions, 1 … 16.

    Returns
    -------
    (H, W, scales · orientations) float32
        mm, ≥ 0. Holes have the mean depth before filtering, so the edge of a large hole is seen.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel.

    References
    ----------
    C. Liu, H. Wechsler, IEEE TIP 11(4), 2002, doi:10.1109/TIP.2002.999679.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> import numpy as np
    >>> flat = RangeImage(np.ones((8, 8)), Orthographic(2.0, 4, 4, 8, 8))
    >>> gabor(flat).shape, float(gabor(flat).max())
    ((8, 8, 12), 0.0)
    """
    pitch_of(image)
    relief = holes.fill_mean(-image.depth)
    return wavelets.magnitudes(relief, scales=scales, orientations=orientations)
