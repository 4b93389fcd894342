"""Local binary patterns of the relief."""

from __future__ import annotations

from rangeface.describe._frontal import pitch_of
from rangeface.numerics import gaussian, patterns
from rangeface.types import Float32, RangeImage


def lbp(
    image: RangeImage,
    *,
    points: int = 8,
    radius_px: float = 1.0,
    method: str = "riu2",
    sigma_px: float = 1.0,
) -> Float32:
    """Local binary patterns LBP_{P,R} of the relief, nearer being greater.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    points : {8, 16, 24}
        Number of neighbours P.
    radius_px : float
        Radius R of their circle, px, > 0; neighbours are interpolated.
    method : {"basic", "u2", "ri", "riu2"}
        Label of a code, see `rangeface.numerics.patterns.lbp`.
    sigma_px : float
        Gaussian smoothing before the comparison, px, ≥ 0; 0 is the paper's operator. The
        patterns compare neighbours that noise reorders: without smoothing little is left.

    Returns
    -------
    (H, W) float32
        Labels, whole numbers from 0 to the number of labels − 1. A missing neighbour counts
        as level with its centre, and a hole has the label of a flat patch.

    Raises
    ------
    ParameterError
        The image is not frontal or smaller than the neighbourhood, or a parameter is out of
        range.
    DegenerateError
        The image has no valid pixel.

    References
    ----------
    T. Ojala, M. Pietikäinen, T. Mäenpää, IEEE TPAMI 24(7), 2002,
    doi:10.1109/TPAMI.2002.1017623.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> peak = [[1.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0]]
    >>> lbp(RangeImage(peak, Orthographic(2.0, 1, 1, 3, 3)), sigma_px=0)[1, 1]
    np.float32(0.0)
    """
    pitch_of(image)
    relief = gaussian.smooth(-image.depth, sigma_px)
    return patterns.lbp(relief, points=points, radius_px=radius_px, method=method)
