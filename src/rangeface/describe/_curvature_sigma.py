"""How well the curvature is known."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import pitch_of, sigma_of
from rangeface.numerics import curvature as measure
from rangeface.types import Float32, RangeImage


def curvature_sigma(
    image: RangeImage,
    *,
    kind: str = "mean",
    radius_mm: float = 10.0,
    sigma_mm: float | None = None,
) -> Float32:
    """Standard deviation of `curvature` by fit, from the noise of the depth.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    kind : {"gaussian", "mean", "maximal", "minimal", "shape_index", "curvedness"}
        As for `curvature`.
    radius_mm : float
        As for `curvature`.
    sigma_mm : float, optional
        Standard deviation of the depth, mm, > 0; by default the image's own `sigma`.

    Returns
    -------
    (H, W) float32
        In the unit of the measure; ∞ where the measure has no derivative, NaN where there is
        no curvature: here a gap is an answer.

    Raises
    ------
    ParameterError
        The image is not frontal, no σ is known, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel.

    Notes
    -----
    To first order, for noise that is independent between pixels.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((11, 11)), Orthographic(2.0, 5, 5, 11, 11))
    >>> curvature_sigma(flat, sigma_mm=1.0)[5, 5].round(4)
    np.float32(0.0073)
    """
    pitch_mm = pitch_of(image)
    sigma = sigma_of(image, sigma_mm)
    K, H, C = measure.by_fit_with_sigma(image.depth, pitch_mm, radius=radius_mm, sigma=sigma)
    return np.asarray(measure.sigma_of_kind(kind, K, H, C), np.float32)
