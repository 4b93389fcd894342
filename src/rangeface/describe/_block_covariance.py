"""Covariance of position, normal and gradient by block."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import pitch_of
from rangeface.describe._normals import gaussian_map
from rangeface.errors import ParameterError
from rangeface.numerics import regions
from rangeface.types import Float32, RangeImage


def block_covariance(
    image: RangeImage,
    *,
    blocks: tuple[int, int] = (6, 4),
    length_mm: float = 10.0,
    method: str = "plane",
    radius_px: float = 2.0,
) -> Float32:
    r"""Log-covariance of (x, y, z, N₁, N₂, N₃, \|∂z/∂x\|, \|∂z/∂y\|) in every block of a grid.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    blocks : tuple of int
        Rows and columns of the grid of blocks.
    length_mm : float
        What counts as one unit of x, y and z, mm, > 0: brings lengths to the size of normals.
    method : {"difference", "plane", "quadric"}
        How the normals are found, as for `normals`.
    radius_px : float
        As for `normals`.

    Returns
    -------
    (rows · columns · 36,) float32
        Euclidean distance between two such vectors is the log-Euclidean distance of the
        matrices. A block with fewer than nine valid pixels has the mean of the others.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel, or no block has enough of them.

    References
    ----------
    O. Tuzel, F. Porikli, P. Meer, ECCV 2006, doi:10.1007/11744047_45; V. Arsigny et al., MRM
    56(2), 2006, doi:10.1002/mrm.20965.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((80, 50)), Orthographic(2.8, 25, 40, 50, 80))
    >>> block_covariance(flat).shape
    (864,)
    """
    pitch_of(image)
    if not (np.isfinite(length_mm) and length_mm > 0):
        raise ParameterError(f"length_mm: must be > 0, got {length_mm}")
    N = gaussian_map(image, method=method, radius_px=radius_px)
    slopes = np.abs(N[..., :2] / np.maximum(N[..., 2:], 0.1))
    features = np.concatenate([image.points / length_mm, N, slopes], axis=-1)
    return regions.block_covariance(features, blocks=blocks)
