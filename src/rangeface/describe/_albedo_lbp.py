"""Local binary patterns of the infrared albedo."""

from __future__ import annotations

from rangeface.describe._albedo import log_albedo
from rangeface.numerics import gaussian, patterns
from rangeface.types import Float32, RangeImage


def albedo_lbp(
    image: RangeImage,
    *,
    points: int = 8,
    radius_px: float = 1.0,
    method: str = "riu2",
    sigma_px: float = 1.0,
    distance_mm: float = 700.0,
) -> Float32:
    """Local binary patterns of the infrared albedo.

    Parameters
    ----------
    image : RangeImage
        Frontal image with an amplitude.
    points, radius_px, method, sigma_px
        As for `lbp`.
    distance_mm : float
        As for `albedo`.

    Returns
    -------
    (H, W) float32
        Labels, as for `lbp`; so are the holes.

    Raises
    ------
    ParameterError
        The image is not frontal or has no amplitude, or a parameter is out of range.
    DegenerateError
        No pixel has depth and amplitude.

    Notes
    -----
    An infrared feature: results that use it are reported apart from those of depth alone.

    References
    ----------
    T. Ojala, M. Pietikäinen, T. Mäenpää, IEEE TPAMI 24(7), 2002,
    doi:10.1109/TPAMI.2002.1017623.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> import numpy as np
    >>> even = np.full((5, 5), 100.0)
    >>> flat = RangeImage(np.zeros((5, 5)), Orthographic(2.0, 2, 2, 5, 5), amplitude=even)
    >>> albedo_lbp(flat, distance_mm=1e6)[2, 2]
    np.float32(8.0)
    """
    relative = log_albedo(image, distance_mm=distance_mm, radius_px=2.0, limit=4.0)
    smooth = gaussian.smooth(relative, sigma_px)
    return patterns.lbp(smooth, points=points, radius_px=radius_px, method=method)
