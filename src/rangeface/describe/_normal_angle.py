"""The angle of the normals in the image plane."""

from __future__ import annotations

import numpy as np

from rangeface.describe._normals import gaussian_map
from rangeface.numerics import holes, sphere
from rangeface.numerics.phase import unwrap
from rangeface.types import Float32, RangeImage


def normal_angle(
    image: RangeImage, *, unwrapped: bool = True, method: str = "plane", radius_px: float = 2.0
) -> Float32:
    r"""The angle arg π(N) = atan2(N₂, N₁), unwrapped by weighted least squares.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    unwrapped : bool
        False gives the paper's angle, with its jumps of 2π.
    method : {"difference", "plane", "quadric"}
        As for `normals`.
    radius_px : float
        As for `normals`.

    Returns
    -------
    (H, W) float32
        rad; in (−π, π] where wrapped, of weighted mean 0 where unwrapped. A pixel
        without a normal has the mean of the others.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        No pixel has a normal.

    Notes
    -----
    The weight of a pixel is sin θ = √(N₁² + N₂²), because noise in N turns into noise of the
    angle as 1/sin θ. Around a peak such as the nose tip the angle runs once through 2π, which
    no surface can follow: what is returned there is the least-squares compromise. Opposite
    cheeks have opposite angles, so the constant of that surface is next to undetermined; it is
    set so that the weighted mean is 0.

    References
    ----------
    The paper's eq. 3.7; D. C. Ghiglia, L. A. Romero, JOSA A 11(1), 1994,
    doi:10.1364/JOSAA.11.000107.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> slope = np.add.outer(2.0 * np.arange(5), np.zeros(5))  # falls back towards the chin
    >>> angle = normal_angle(RangeImage(slope, Orthographic(2.0, 2, 2, 5, 5)), unwrapped=False)
    >>> angle[2, 2].round(4)
    np.float32(-1.5708)
    """
    N = gaussian_map(image, method=method, radius_px=radius_px)
    angle = sphere.polar_stereographic(N)[..., 1]
    if unwrapped and np.isfinite(angle).any():
        known = np.isfinite(angle)
        weight = np.where(known, np.hypot(N[..., 0], N[..., 1]) + 1e-6, 0.0)
        surface = unwrap(angle, weight)
        angle = np.where(known, surface - np.average(surface, weights=weight), np.nan)
    return holes.fill_mean(angle)
