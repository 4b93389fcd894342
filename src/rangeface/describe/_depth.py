"""Depth behind the nose tip."""

from __future__ import annotations

from rangeface.describe._frontal import pitch_of
from rangeface.numerics import holes
from rangeface.types import Float32, RangeImage


def depth(image: RangeImage) -> Float32:
    """Depth behind the nose tip, mm.

    Parameters
    ----------
    image : RangeImage
        Frontal image: orthographic, in the face frame, whose origin is the nose tip.

    Returns
    -------
    (H, W) float32
        mm, 0 at the nose tip, greater behind it. A hole has the mean depth of the others.

    Raises
    ------
    ParameterError
        The image is not frontal.
    DegenerateError
        The image has no valid pixel.

    Notes
    -----
    The reference is the frame's origin, not this image's nearest pixel and not its range of
    values: scaling each image to its own minimum and maximum gives away the size of the face.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> depth(RangeImage([[0.0, float("nan"), 9.0]], Orthographic(2.0, 0, 0, 3, 1)))
    array([[0. , 4.5, 9. ]], dtype=float32)
    """
    pitch_of(image)
    return holes.fill_mean(image.depth)
