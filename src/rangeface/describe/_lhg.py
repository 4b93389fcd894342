"""Large horizontal gradient (LHG) of the relief."""

from __future__ import annotations

from rangeface.describe._frontal import pitch_of
from rangeface.numerics import gaussian, gradients
from rangeface.types import Float32, RangeImage


def lhg(image: RangeImage, *, sigma_px: float = 0.0) -> Float32:
    """Large horizontal gradient (LHG) of the relief, nearer being greater.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    sigma_px : float
        Gaussian smoothing before it, px, ≥ 0; 0 is the paper's operator.

    Returns
    -------
    (H, W) float32
        mm, as the mask gives it (not divided by a length). A pair of pixels that is not complete
        counts as level, and a hole has 0.

    Raises
    ------
    ParameterError
        The image is not frontal or smaller than the mask, or the smoothing is out of range.
    DegenerateError
        The image has no valid pixel.

    References
    ----------
    The paper's eq. 3.8 and the text above it; see `rangeface.numerics.gradients`.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> import numpy as np
    >>> nearer_to_the_right = np.tile(-np.arange(5.0), (5, 1))
    >>> lhg(RangeImage(nearer_to_the_right, Orthographic(2.0, 2, 2, 5, 5)))[2, 2]
    np.float32(4.0)
    """
    pitch_of(image)
    return gradients.lhg(gaussian.smooth(-image.depth, sigma_px))
