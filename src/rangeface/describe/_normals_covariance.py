"""How well the normals are known."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import pitch_of, sigma_of
from rangeface.numerics import localfit
from rangeface.numerics import normals as estimate
from rangeface.types import Float32, RangeImage


def normals_covariance(
    image: RangeImage,
    *,
    method: str = "plane",
    radius_px: float = 2.0,
    sigma_mm: float | None = None,
) -> Float32:
    r"""Covariance of each unit normal, from the noise of the depth.

    .. math:: Σ_N = J (Φ^T W Φ)^{-1}_{pq} J^T, \quad J = ∂N/∂(p, q)

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    method : {"plane", "quadric"}
        The fit, as for `normals`.
    radius_px : float
        As for `normals`.
    sigma_mm : float, optional
        Standard deviation of the depth, mm, > 0; by default the image's own `sigma`.

    Returns
    -------
    (H, W, 3, 3) float32
        Of the components of `normals`; NaN where there is no normal: here a gap is an answer.

    Raises
    ------
    ParameterError
        The image is not frontal, no σ is known, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel.

    Notes
    -----
    To first order, for noise that is independent between pixels; what smoothing or resampling
    has correlated is known less well than it says.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((5, 5)), Orthographic(1.0, 2, 2, 5, 5))
    >>> normals_covariance(flat, radius_px=1, sigma_mm=0.1)[2, 2].diagonal().round(4)
    array([0.005, 0.005, 0.   ], dtype=float32)
    """
    pitch = np.float32(pitch_of(image))
    degree = {"plane": 1, "quadric": 2}.get(method, 0)
    fitted, covariance = localfit.fit_with_covariance(
        image.depth, sigma=sigma_of(image, sigma_mm), radius_px=radius_px, degree=degree
    )
    p, q = fitted[..., 1] / pitch, fitted[..., 2] / pitch
    found = estimate.covariance_of_slopes(p, q, covariance[..., 1:3, 1:3] / pitch**2)
    to_feature_frame = np.array([1.0, -1.0, -1.0], np.float32)
    return found * to_feature_frame[:, None] * to_feature_frame
