"""Local normal patterns."""

from __future__ import annotations

import numpy as np

from rangeface.describe._normals import gaussian_map
from rangeface.numerics import patterns
from rangeface.types import Float32, RangeImage


def local_normal_patterns(
    image: RangeImage,
    *,
    points: int = 8,
    radius_px: float = 1.0,
    label: str = "u2",
    method: str = "plane",
    fit_radius_px: float = 2.0,
) -> Float32:
    """Local binary patterns of the three components of the normals.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    points : {8, 16, 24}
        Number of neighbours P.
    radius_px : float
        Radius R of their circle, px, > 0.
    label : {"basic", "u2", "ri", "riu2"}
        Label of a code, as `method` of `lbp`.
    method : {"difference", "plane", "quadric"}
        How the normals are found, as for `normals`.
    fit_radius_px : float
        Radius of that fit, as for `normals`.

    Returns
    -------
    (H, W, 3) float32
        Labels of N₁, N₂, N₃. Holes as for `lbp`.

    Raises
    ------
    ParameterError
        The image is not frontal or smaller than the neighbourhood, or a parameter is out of
        range.
    DegenerateError
        The image has no valid pixel.

    References
    ----------
    H. Li, D. Huang, J.-M. Morvan, L. Chen, Y. Wang, Neurocomputing 133, 2014,
    doi:10.1016/j.neucom.2013.11.018.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((5, 5)), Orthographic(2.0, 2, 2, 5, 5))
    >>> local_normal_patterns(flat)[2, 2]
    array([57., 57., 57.], dtype=float32)
    """
    N = gaussian_map(image, method=method, radius_px=fit_radius_px)
    codes = patterns.lbp(np.moveaxis(N, -1, 0), points=points, radius_px=radius_px, method=label)
    return np.ascontiguousarray(np.moveaxis(codes, 0, -1))
