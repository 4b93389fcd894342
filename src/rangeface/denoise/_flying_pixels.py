from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rangeface.denoise import _check
from rangeface.denoise._noise import sigma_map
from rangeface.errors import ParameterError
from rangeface.types import Float32, Orthographic, RangeImage

_NEIGHBOURS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))


def flying_pixels(
    image: RangeImage,
    *,
    max_incidence_deg: float = 80.0,
    min_neighbours: int = 3,
    noise_factor: float = 3.0,
) -> RangeImage:
    r"""Remove spikes, and the mixed pixels that float between a face and its background.

    A neighbour supports a pixel if no surface seen under less than the greatest incidence
    would need more than this step between them:

    .. math:: |z_p - z_q| \le d_{pq} \tan θ_{max} + k \sqrt{σ_p^2 + σ_q^2}

    with d the distance of their footprints. A pixel with too few supporters is removed.

    Parameters
    ----------
    image : RangeImage
        Any image.
    max_incidence_deg : float
        θ_max between ray and surface normal, degrees, 0 … 90.
    min_neighbours : int
        Of the eight neighbours, how many must support a pixel, 1 … 8.
    noise_factor : float
        k ≥ 0. σ is the sensor's, or estimated from the image.

    Returns
    -------
    RangeImage
        With more holes, otherwise untouched.

    Raises
    ------
    ParameterError
        A parameter is outside its range.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> depth = np.full((6, 6), 400.0)
    >>> depth[1, 2] = 600.0
    >>> out = flying_pixels(RangeImage(depth, Orthographic(2.0, 2, 2, 6, 6)))
    >>> np.argwhere(~out.mask).tolist()
    [[1, 2]]
    """
    if not 0.0 < max_incidence_deg < 90.0:
        raise ParameterError(f"max_incidence_deg must lie in 0 … 90, got {max_incidence_deg}")
    if not 1 <= min_neighbours <= 8:
        raise ParameterError(f"min_neighbours must lie in 1 … 8, got {min_neighbours}")
    _check.not_negative("noise_factor", noise_factor)
    slope = np.float32(np.tan(np.deg2rad(max_incidence_deg)))
    step = slope * _pitch(image)
    supporters = _supporters(image.depth, step, sigma_map(image) ** 2, noise_factor)
    return image.masked(supporters >= min_neighbours)


def _pitch(image: RangeImage) -> Float32:
    if isinstance(image.camera, Orthographic):
        return np.full(image.shape, image.camera.pitch_mm, dtype=np.float32)
    return image.depth * np.float32(image.camera.pixel_mm(1.0))


def _supporters(
    depth: Float32, step: Float32, variance: Float32, noise_factor: float
) -> NDArray[np.int8]:
    z, s, v = (np.pad(plane, 1, constant_values=np.nan) for plane in (depth, step, variance))
    rows, cols = depth.shape
    count: NDArray[np.int8] = np.zeros(depth.shape, dtype=np.int8)
    for dy, dx in _NEIGHBOURS:
        there = (slice(1 + dy, 1 + dy + rows), slice(1 + dx, 1 + dx + cols))
        # the nearer of the two has the smaller footprint: a far background vouches for nobody
        allowed = np.hypot(dy, dx) * np.fmin(step, s[there])
        allowed = allowed + noise_factor * np.sqrt(variance + v[there])
        count += np.abs(z[there] - depth) <= allowed
    return count
