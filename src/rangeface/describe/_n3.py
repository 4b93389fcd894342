"""The third component of the normals."""

from __future__ import annotations

from rangeface.describe._normals import gaussian_map
from rangeface.numerics import holes
from rangeface.types import Float32, RangeImage


def n3(image: RangeImage, *, method: str = "plane", radius_px: float = 2.0) -> Float32:
    """The component N₃ of the normals, along the optical axis towards the camera.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    method : {"difference", "plane", "quadric"}
        As for `normals`.
    radius_px : float
        As for `normals`.

    Returns
    -------
    (H, W) float32
        0 … 1: the cosine of the angle between the surface and the image plane, that is the
        picture of a uniformly reflecting face under a distant lamp at the camera. A pixel
        without a normal has the mean of the others.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        No pixel has a normal.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> import numpy as np
    >>> n3(RangeImage(np.zeros((5, 5)), Orthographic(2.0, 2, 2, 5, 5)))[2, 2]
    np.float32(1.0)
    """
    return holes.fill_mean(gaussian_map(image, method=method, radius_px=radius_px)[..., 2])
