"""Curvature of the face."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import pitch_of
from rangeface.errors import ParameterError
from rangeface.numerics import curvature as measure
from rangeface.numerics import holes
from rangeface.types import Float32, RangeImage


def curvature(
    image: RangeImage, *, kind: str = "mean", method: str = "fit", radius_mm: float = 10.0
) -> Float32:
    """Gaussian, mean or principal curvature, shape index or curvedness.

    Parameters
    ----------
    image : RangeImage
        Frontal image; its `sigma`, where known, weights the fit by 1/σ².
    kind : {"gaussian", "mean", "maximal", "minimal", "shape_index", "curvedness"}
        Measure, see `rangeface.numerics.curvature.of_kind`.
    method : {"fit", "difference"}
        Least-squares quadric over a disc, or second differences over 3 × 3 pixels, which noise
        swamps (figure 5 of the paper).
    radius_mm : float
        Radius of the disc, mm, √2 … 15 pixels; no meaning for "difference".

    Returns
    -------
    (H, W) float32
        1/mm² for "gaussian", −1 … 1 for "shape_index", else 1/mm; positive mean curvature
        bulges towards the camera. A pixel without curvature has the mean of the others.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        No pixel has a curvature.

    References
    ----------
    P. J. Besl, R. C. Jain, IEEE TPAMI 10(2), 1988, doi:10.1109/34.3881.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> y, x = np.mgrid[-5:6, -5:6] * 2.0
    >>> ball = RangeImage(50 - np.sqrt(2500 - x**2 - y**2), Orthographic(2.0, 5, 5, 11, 11))
    >>> curvature(ball, radius_mm=4)[5, 5].round(4)
    np.float32(0.02)
    """
    pitch_mm = pitch_of(image)
    if method == "difference":
        K, H = measure.by_differences(image.depth, pitch_mm)
    elif method == "fit":
        K, H = measure.by_fit(image.depth, pitch_mm, radius=radius_mm, sigma=image.sigma)
    else:
        raise ParameterError(f"method: must be 'fit' or 'difference', got {method!r}")
    return holes.fill_mean(np.asarray(measure.of_kind(kind, K, H), np.float32))
