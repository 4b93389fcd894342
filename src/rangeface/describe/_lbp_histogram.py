"""Regional histograms of local binary patterns."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from rangeface.describe._frontal import pitch_of
from rangeface.errors import ParameterError
from rangeface.numerics import gaussian, histograms, patterns
from rangeface.types import Float32, RangeImage

Scales: TypeAlias = tuple[tuple[int, float], ...]


def lbp_histogram(
    image: RangeImage,
    *,
    scales: Scales = ((8, 1.0), (8, 2.0)),
    method: str = "u2",
    regions: tuple[int, int] = (5, 4),
    sigma_px: float = 1.0,
) -> Float32:
    """Histograms of local binary patterns by region, at one or more scales.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    scales : tuple of (int, float)
        Number of neighbours P and radius R, px, of every scale.
    method : {"basic", "u2", "ri", "riu2"}
        Label map, as for `lbp`; "basic" and "ri" only with P = 8.
    regions : tuple of int
        Rows and columns of the grid of regions.
    sigma_px : float
        As for `lbp`.

    Returns
    -------
    (n,) float32
        0 … 1, every region's histogram summing to 1, scale after scale. Holes are not counted;
        a region of holes has the histogram of the whole face. Compare by χ² or
        intersection: `rangeface.numerics.similarity`.

    Raises
    ------
    ParameterError
        The image is not frontal or smaller than a neighbourhood, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel.

    References
    ----------
    T. Ahonen, A. Hadid, M. Pietikäinen, IEEE TPAMI 28(12), 2006, doi:10.1109/TPAMI.2006.244.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((10, 8)), Orthographic(2.0, 4, 5, 8, 10))
    >>> lbp_histogram(flat, scales=((8, 1.0),), regions=(1, 1)).shape
    (59,)
    """
    pitch_of(image)
    if not scales:
        raise ParameterError("scales: at least one (P, R) is needed")
    for points, radius_px in scales:
        patterns.check(points, radius_px, method)
        if points > 8 and method in ("basic", "ri"):
            raise ParameterError(
                f"method: {method!r} has 2^{points} labels; use 'u2' or 'riu2' with P > 8"
            )
    relief = gaussian.smooth(-image.depth, sigma_px)
    return np.concatenate(
        [
            histograms.regional(
                patterns.lbp(relief, points=points, radius_px=radius_px, method=method),
                image.mask,
                count=patterns.label_count(points, method),
                regions=regions,
            )
            for points, radius_px in scales
        ]
    )
