"""The surface itself: depth, and how well it is known."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import camera_of
from rangeface.errors import ParameterError
from rangeface.types import Float32, RangeImage


def surface(image: RangeImage, *, sigma_mm: float = 1.0) -> Float32:
    """Depth behind the nose tip and its inverse variance: what matchers of surfaces align.

    Parameters
    ----------
    image : RangeImage
        Frontal image: orthographic, in the face frame, whose origin is the nose tip.
    sigma_mm : float
        Standard deviation of the depth where the image does not know it, > 0.

    Returns
    -------
    (H, W, 2) float32
        Depth, mm, and 1/σ², 1/mm²; the latter is 0 in holes and where the depth was filled in,
        and at most 1/(0.3 mm)².

    Raises
    ------
    ParameterError
        The image is not frontal, or σ is not positive.
    DegenerateError
        The image has no valid pixel.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> surface(RangeImage([[0.0, float("nan"), 9.0]], Orthographic(2.0, 0, 0, 3, 1)))
    array([[[0., 1.],
            [0., 0.],
            [9., 1.]]], dtype=float32)
    """
    camera_of(image)
    if not (np.isfinite(sigma_mm) and sigma_mm > 0):
        raise ParameterError(f"sigma_mm: must be > 0, got {sigma_mm}")
    measured = image.mask if image.filled is None else image.mask & ~image.filled
    sigma = np.full(image.shape, sigma_mm) if image.sigma is None else image.sigma
    known = measured & np.isfinite(sigma)
    certainty = np.where(known, np.maximum(np.where(known, sigma, 1.0), 0.3) ** -2.0, 0.0)
    return np.stack([np.nan_to_num(image.depth), certainty], axis=-1).astype(np.float32)
