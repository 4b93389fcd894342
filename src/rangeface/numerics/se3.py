"""Rigid motions: rotation vectors, matrices, head angles, and the closed-form best fit."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError

Matrix: TypeAlias = NDArray[np.float64]


def rotation_matrix(vector: ArrayLike) -> Matrix:
    r"""Rotation matrix of a rotation vector (axis times angle), by Rodrigues' formula.

    .. math:: R = I + \frac{\sin θ}{θ} [w]_× + \frac{1 - \cos θ}{θ^2} [w]_×^2

    Parameters
    ----------
    vector : (3,) array_like
        Rotation vector w, rad.

    Returns
    -------
    (3, 3) float64
        Proper rotation, det = +1.

    Examples
    --------
    >>> rotation_matrix([0.0, 0.0, np.pi / 2]).round(6) @ [1, 0, 0]
    array([0., 1., 0.])
    """
    w = np.asarray(vector, dtype=np.float64)
    theta = float(np.linalg.norm(w))
    W = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    # np.sinc(x) = sin(πx)/(πx), so both factors stay finite at θ = 0
    first = np.sinc(theta / np.pi)
    second = 0.5 * np.sinc(theta / (2.0 * np.pi)) ** 2
    return np.asarray(np.eye(3) + first * W + second * (W @ W), dtype=np.float64)


def rotation_angle(rotation: ArrayLike) -> float:
    """Angle of a rotation matrix, rad in [0, π].

    Parameters
    ----------
    rotation : (3, 3) array_like
        Proper rotation.

    Returns
    -------
    float
        Angle in rad.

    Notes
    -----
    Uses atan2 of the skew part and the trace: exact near 0 and near π, where arccos is not.

    Examples
    --------
    >>> round(float(np.rad2deg(rotation_angle(rotation_matrix([0.0, 0.3, 0.0])))), 3)
    17.189
    """
    R = np.asarray(rotation, dtype=np.float64)
    skew = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return float(np.arctan2(0.5 * np.linalg.norm(skew), 0.5 * (np.trace(R) - 1.0)))


def head_rotation(yaw: float, pitch: float, roll: float) -> Matrix:
    """Rotation R_camera_face of a head with the given angles (camera frame: x right, y down).

    Positive yaw turns the face towards +x (the right of the image), positive pitch turns it
    down (+y), positive roll tilts it clockwise as seen in the image. Roll acts first, then
    pitch, then yaw.

    Parameters
    ----------
    yaw, pitch, roll : float
        Angles, rad.

    Returns
    -------
    (3, 3) float64
        Rotation that takes face coordinates to camera coordinates.

    Examples
    --------
    A face looks along −z of its own frame; yaw 90° makes it look along +x:

    >>> (head_rotation(np.pi / 2, 0.0, 0.0) @ [0.0, 0.0, -1.0]).round(6) + 0.0
    array([1., 0., 0.])
    """
    return (
        rotation_matrix([0.0, -yaw, 0.0])
        @ rotation_matrix([pitch, 0.0, 0.0])
        @ rotation_matrix([0.0, 0.0, roll])
    )


def head_angles(rotation: ArrayLike) -> tuple[float, float, float]:
    """Yaw, pitch and roll of R_camera_face: the inverse of `head_rotation`.

    Parameters
    ----------
    rotation : (3, 3) array_like
        Rotation R_camera_face.

    Returns
    -------
    tuple of float
        Yaw, pitch, roll in rad; pitch lies in [−π/2, π/2].

    Examples
    --------
    >>> [round(a, 6) for a in head_angles(head_rotation(0.4, -0.2, 0.1))]
    [0.4, -0.2, 0.1]
    """
    R = np.asarray(rotation, dtype=np.float64)
    # columns of R: where the face's axes point in the camera; −R[:, 2] is the looking direction
    yaw = float(np.arctan2(-R[0, 2], R[2, 2]))
    pitch = float(np.arcsin(np.clip(-R[1, 2], -1.0, 1.0)))
    roll = float(np.arctan2(R[1, 0], R[1, 1]))
    return yaw, pitch, roll


def best_fit(source: ArrayLike, target: ArrayLike) -> tuple[Matrix, Matrix]:
    r"""Rigid motion that takes paired points onto each other in the least-squares sense.

    .. math:: \min_{R, t} \sum_k \| R s_k + t - t_k \|^2, \quad \det R = +1

    Parameters
    ----------
    source, target : (n, 3) array_like
        Paired points, n ≥ 3, not collinear, any length unit.

    Returns
    -------
    rotation : (3, 3) float64
    translation : (3,) float64

    Raises
    ------
    DegenerateError
        Fewer than three points, or collinear ones.

    References
    ----------
    S. Umeyama, IEEE TPAMI 13(4), 1991, doi:10.1109/34.88573 (eq. 40–42, without scale).
    """
    s = np.asarray(source, dtype=np.float64)
    t = np.asarray(target, dtype=np.float64)
    if s.ndim != 2 or s.shape != t.shape or s.shape[1] != 3 or len(s) < 3:
        raise DegenerateError(f"best_fit needs two (n ≥ 3, 3) arrays, got {s.shape} and {t.shape}")
    mean_s, mean_t = s.mean(axis=0), t.mean(axis=0)
    U, D, Vt = np.linalg.svd((t - mean_t).T @ (s - mean_s))
    if D[1] <= 1e-9 * max(D[0], 1e-30):
        raise DegenerateError("best_fit: the points are collinear and leave a rotation open")
    S = np.diag([1.0, 1.0, np.sign(np.linalg.det(U) * np.linalg.det(Vt))])
    R = U @ S @ Vt
    return R, mean_t - R @ mean_s
