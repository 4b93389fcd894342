"""Infrared albedo."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import amplitude_of, camera_of
from rangeface.describe._normals import gaussian_map
from rangeface.errors import ParameterError
from rangeface.numerics import holes
from rangeface.types import Float32, RangeImage


def albedo(
    image: RangeImage, *, distance_mm: float = 700.0, radius_px: float = 2.0, limit: float = 4.0
) -> Float32:
    r"""Logarithm of the albedo under the camera's own light, relative to the face's median.

    .. math:: ρ ∝ A r^2 / \cos θ

    Parameters
    ----------
    image : RangeImage
        Frontal image with an amplitude.
    distance_mm : float
        Distance of the nose tip from the camera, mm, > 0. Only r/distance enters, so a rough
        value does.
    radius_px : float
        Radius of the plane fit that gives the normals, px.
    limit : float
        Albedos beyond this factor of the median, either way, are cut there, > 1.

    Returns
    -------
    (H, W) float32
        Natural logarithm, −log limit … log limit; 0 is the median. A pixel without amplitude
        or normal has the mean of the others.

    Raises
    ------
    ParameterError
        The image is not frontal or has no amplitude, or a parameter is out of range.
    DegenerateError
        No pixel has depth and amplitude, or none has a normal.

    Notes
    -----
    An infrared feature: results that use it are reported apart from those of depth alone.
    cos θ is taken against the optical axis of the frontal view, which is the light's direction
    only where the face looked at the camera; it is held above 0.2. A is linear amplitude: an
    unknown scale cancels, a logarithmic coding does not.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> light = np.full((5, 5), 100.0)
    >>> light[2, 2] = 200.0
    >>> flat = RangeImage(np.zeros((5, 5)), Orthographic(2.0, 2, 2, 5, 5), amplitude=light)
    >>> albedo(flat)[2, 1:4].round(3) + 0.0
    array([0.   , 0.693, 0.   ], dtype=float32)
    """
    return holes.fill_mean(
        log_albedo(image, distance_mm=distance_mm, radius_px=radius_px, limit=limit)
    )


def log_albedo(image: RangeImage, *, distance_mm: float, radius_px: float, limit: float) -> Float32:
    """As `albedo`, with NaN where it is not known."""
    camera = camera_of(image)
    A = amplitude_of(image)
    if not (np.isfinite(distance_mm) and distance_mm > 0):
        raise ParameterError(f"distance_mm: must be > 0, got {distance_mm}")
    if not (np.isfinite(limit) and limit > 1):
        raise ParameterError(f"limit: must be > 1, got {limit}")
    cosine = np.maximum(gaussian_map(image, method="plane", radius_px=radius_px)[..., 2], 0.2)
    x, y, z = np.moveaxis(camera.back_project(image.depth), -1, 0)
    r2 = x * x + y * y + (z + distance_mm) ** 2
    logarithm = np.log(A * r2 / cosine)
    if np.isfinite(logarithm).any():
        logarithm = logarithm - np.nanmedian(logarithm)
    return np.asarray(np.clip(logarithm, -np.log(limit), np.log(limit)), np.float32)
