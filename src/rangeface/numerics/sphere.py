r"""Maps of the visible hemisphere of unit normals into flat coordinates.

Here a normal is in the *feature frame* of the paper's figure 6: N₁ to the right, N₂ up, N₃
along the optical axis **towards the camera**, so that a visible surface has N₃ ≥ 0.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float32: TypeAlias = NDArray[np.float32]


def from_camera(normals: ArrayLike) -> Float32:
    """Normals of the camera frame (x right, y down, z forward) in the feature frame.

    Parameters
    ----------
    normals : (…, 3) array_like
        Unit normals that point towards the camera, hence with z ≤ 0.

    Returns
    -------
    (…, 3) float32
        (x, −y, −z).

    Examples
    --------
    >>> from_camera([0.0, 0.6, -0.8])
    array([ 0. , -0.6,  0.8], dtype=float32)
    """
    return np.asarray(normals, np.float32) * np.array([1.0, -1.0, -1.0], np.float32)


def polar_stereographic(normals: ArrayLike) -> Float32:
    r"""The pair (N₃, arg π(N)) of the paper, literally.

    .. math:: π(N) = \frac{N_1 + i N_2}{1 - N_3}, \qquad \arg π(N) = \mathrm{atan2}(N_2, N_1)

    Parameters
    ----------
    normals : (…, 3) array_like
        Unit normals in the feature frame.

    Returns
    -------
    (…, 2) float32
        N₃ in [−1, 1] and the angle in (−π, π], rad.

    Notes
    -----
    Eq. 3.7 of the paper. Its factor 1/(1 − N₃) is positive and plays no part in the angle.
    The angle jumps by 2π across N₁ < 0, N₂ = 0 and means nothing where N points at the
    camera: the flat patches of a face turn noise into any angle.

    Examples
    --------
    >>> polar_stereographic([0.0, 0.6, 0.8])
    array([0.8      , 1.5707964], dtype=float32)
    """
    n = np.asarray(normals, np.float32)
    return np.stack([n[..., 2], np.arctan2(n[..., 1], n[..., 0])], axis=-1)


def stereographic(normals: ArrayLike) -> Float32:
    r"""Stereographic projection from the pole that no visible normal reaches.

    .. math:: (N_1, N_2) / (1 + N_3)

    Parameters
    ----------
    normals : (…, 3) array_like
        Unit normals in the feature frame, N₃ > −1.

    Returns
    -------
    (…, 2) float32
        Real and imaginary part; the visible hemisphere is the unit disc.

    Notes
    -----
    Conformal. Eq. 3.7 projects from the other pole, N₃ = 1, where a face has most normals.

    Examples
    --------
    >>> stereographic([0.6, 0.0, 0.8]).round(4)
    array([0.3333, 0.    ], dtype=float32)
    """
    n = np.asarray(normals, np.float32)
    return n[..., :2] / (1.0 + n[..., 2:])


def lambert(normals: ArrayLike) -> Float32:
    r"""Lambert's azimuthal equal-area projection.

    .. math:: \sqrt{2 / (1 + N_3)}\; (N_1, N_2)

    Parameters
    ----------
    normals : (…, 3) array_like
        Unit normals in the feature frame, N₃ > −1.

    Returns
    -------
    (…, 2) float32
        The visible hemisphere is the disc of radius √2.

    References
    ----------
    J. P. Snyder, "Map Projections: A Working Manual", USGS PP 1395, 1987, §24,
    doi:10.3133/pp1395.

    Examples
    --------
    >>> lambert([0.0, 1.0, 0.0]).round(4)
    array([0.    , 1.4142], dtype=float32)
    """
    n = np.asarray(normals, np.float32)
    return n[..., :2] * np.sqrt(2.0 / (1.0 + n[..., 2:]))


def log_map(normals: ArrayLike, base: ArrayLike | None = None) -> Float32:
    r"""Riemannian logarithm on the sphere: the tangent vector that leads from a base to N.

    .. math:: \log_B N = \frac{θ}{\sin θ} (N - \cos θ\, B), \qquad \cos θ = B · N

    Parameters
    ----------
    normals : (…, 3) array_like
        Unit normals in the feature frame, NaN where invalid.
    base : (3,) array_like, optional
        Unit base point B; by default the direction of the mean of the valid normals.

    Returns
    -------
    (…, 2) float32
        Coordinates of the tangent vector, rad: along the image of N₁ and of N₂ under the
        shortest rotation from the optical axis to B.

    Notes
    -----
    Distances from the base are exact; pose changes that turn all normals alike are largely
    taken up by the base.

    References
    ----------
    W. A. P. Smith, E. R. Hancock, IEEE TPAMI 28(12), 2006, doi:10.1109/TPAMI.2006.251.

    Examples
    --------
    >>> log_map([np.sin(0.3), 0.0, np.cos(0.3)], base=[0, 0, 1]).round(6)
    array([0.3, 0. ], dtype=float32)
    """
    n = np.asarray(normals, np.float64)
    if base is None:
        total = np.nansum(n.reshape(-1, 3), axis=0)
        B = total / np.linalg.norm(total)
    else:
        B = np.asarray(base, np.float64)
    # the shortest rotation e₃ → B takes e₁, e₂ to these
    e1 = np.array([1.0 - B[0] ** 2 / (1.0 + B[2]), -B[0] * B[1] / (1.0 + B[2]), -B[0]])
    e2 = np.array([-B[0] * B[1] / (1.0 + B[2]), 1.0 - B[1] ** 2 / (1.0 + B[2]), -B[1]])
    x, y, cosine = n @ e1, n @ e2, n @ B
    sine = np.hypot(x, y)
    factor = np.where(sine > 1e-9, np.arctan2(sine, cosine) / np.maximum(sine, 1e-9), 1.0)
    return np.stack([factor * x, factor * y], axis=-1).astype(np.float32)
