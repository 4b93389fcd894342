"""The symmetry plane of a face, from the face against its own mirror image (figure 8)."""

from __future__ import annotations

import numpy as np

from rangeface.errors import ParameterError
from rangeface.numerics import icp as kernels
from rangeface.numerics.normals import from_points
from rangeface.numerics.pose_search import pool
from rangeface.numerics.projection import Projection
from rangeface.numerics.se3 import rotation_matrix
from rangeface.register._outcome import outcome
from rangeface.types import Alignment, Face, Float32, Float64, Reason, RigidTransform

_MIRROR = np.diag([-1.0, 1.0, 1.0])
_PIXEL_MM = 4.0
_GATES = np.array([30] * 4 + [20] * 4 + [12] * 4 + [10] * 18, np.float32)
_SCALES = np.array([10] * 4 + [7] * 4 + [5] * 4 + [4] * 18, np.float32)
#: The profile's nose tip is sought within this of the start's.
_TIP_WITHIN_MM = 25.0
#: Condition numbers above this leave a direction of the plane to noise (a face has below 60).
_MOST_OPEN = 1000.0


def mirror(
    face: Face,
    *,
    radius_mm: float = 90.0,
    max_rms_mm: float = 5.0,
    min_overlap: float = 0.3,
    max_angle_deg: float = 45.0,
) -> Alignment:
    r"""Turn a face frontal by its own symmetry: yaw, roll and the middle come from its plane.

    The face is mirrored at the middle plane of the start, and the mirror image is registered to
    the face by ICP. Mirroring and motion together are a reflection,

    .. math:: M p = Q p + v, \qquad Q = R S, \\quad S = \mathrm{diag}(-1, 1, 1),

    whose plane has the eigenvector of Q for −1 as its normal and holds the midpoints of p and
    M p. In this plane lies the profile; its most protruding point is the nose tip. Pitch stays
    that of the start: a plane says nothing about it.

    Parameters
    ----------
    face : Face
        With a rough pose, or frontal within about 20°. Both halves must be visible: about 30°.
    radius_mm : float
        Points further from the nose tip take no part, > 0.
    max_rms_mm : float
        A larger residual between the halves is refused.
    min_overlap : float
        0 … 1: less of the mirror image explained is refused.
    max_angle_deg : float
        A head turned further than this is refused: one half hides.

    Returns
    -------
    Alignment
        `overlap` is the part of the visible mirror image that the face explains.

    Raises
    ------
    ParameterError
        `radius_mm` is not positive.
    """
    if not radius_mm > 0:
        raise ParameterError(f"radius_mm must be > 0, got {radius_mm}")
    start = face.pose if face.pose is not None else RigidTransform(np.eye(3), -face.nose_tip)
    points, projection = pooled(face)
    fit = reflection(points, projection, start, radius_mm)
    if fit is None:
        return Alignment(start, converged=False, reason=Reason.TOO_FEW_POINTS)
    transform = _on_its_tip(upright(fit, start), points) if np.isfinite(fit.moved_mm) else start
    reason = refusal(fit, transform, max_rms_mm, min_overlap, max_angle_deg)
    return outcome(fit, transform, reason)


def reflection(
    points: Float32, projection: Projection, start: RigidTransform, radius_mm: float
) -> kernels.Fit | None:
    """The face's mirror image at the middle plane of the start, fitted to the face.

    None where fewer than 100 points lie within the radius.
    """
    model = _mirrored(points, start, radius_mm)
    if len(model.points) < 100:
        return None
    first = start.inverse()
    weights = np.ones(points.shape[:2], np.float32)
    return kernels.align(
        model, projection, points, weights, first.rotation, first.translation,
        gates_mm=_GATES, scales_mm=_SCALES,
    )  # fmt: skip


def pooled(face: Face) -> tuple[Float32, Projection]:
    camera = face.image.camera
    factor = max(round(_PIXEL_MM / camera.pixel_mm(float(face.nose_tip[2]))), 1)
    points = pool(face.image.depth, camera.projection, factor)
    return points, camera.projection.pooled(factor)


def _mirrored(points: Float32, start: RigidTransform, radius_mm: float) -> kernels.Model:
    """The mirror image of the face in the frame of the start."""
    normals = from_points(points)
    own = start.apply(points)
    near = np.isfinite(normals[..., 2]) & (np.linalg.norm(own, axis=-1) <= radius_mm)
    turned = normals[near] @ start.rotation.T
    return kernels.Model(
        np.ascontiguousarray(own[near] @ _MIRROR, np.float32),
        np.ascontiguousarray(turned @ _MIRROR, np.float32),
        np.ones(int(near.sum()), np.float32),
    )


def upright(fit: kernels.Fit, start: RigidTransform) -> RigidTransform:
    """The start, turned and shifted until the symmetry plane of a finite fit is x = 0."""
    # M p = Q p + v in the frame of the start
    Q = start.rotation @ fit.rotation @ _MIRROR
    v = start.rotation @ fit.translation + start.translation
    normal = np.linalg.eigh(0.5 * (Q + Q.T))[1][:, 0]
    normal *= np.sign(normal[0]) or 1.0
    middle = 0.5 * v  # the midpoint of the nose tip and its image lies on the plane
    axis = np.cross(normal, [1.0, 0.0, 0.0])
    sine = float(np.linalg.norm(axis))
    turn = rotation_matrix(np.arcsin(min(sine, 1.0)) * axis / max(sine, 1e-12))
    shift = np.array([-(normal @ middle), 0.0, 0.0])
    return RigidTransform(turn, shift, source="face") @ start


def _on_its_tip(pose: RigidTransform, points: Float32) -> RigidTransform:
    """The pose, shifted until the nose tip of its profile is the origin."""
    return RigidTransform(np.eye(3), -_nose_tip(pose.apply(points)), source="face") @ pose


def _nose_tip(points: Float64) -> Float64:
    """The most protruding point of the profile near the origin; the origin if there is none."""
    profile = np.abs(points[..., 0]) <= 0.75 * _PIXEL_MM
    near = profile & (np.linalg.norm(points, axis=-1) <= _TIP_WITHIN_MM)
    if not near.any():
        return np.zeros(3)
    candidates = points[near]
    tip = candidates[candidates[:, 2].argmin()]
    return np.array([0.0, tip[1], tip[2]])


def refusal(
    fit: kernels.Fit,
    transform: RigidTransform,
    max_rms_mm: float,
    min_overlap: float,
    max_angle_deg: float,
) -> Reason | None:
    if fit.inliers < 60:
        return Reason.TOO_FEW_POINTS
    # a plane or a ball is its own mirror image in any direction: the plane stays open
    if not fit.moved_mm < 1.0 or fit.condition > _MOST_OPEN:
        return Reason.NOT_CONVERGED
    if fit.overlap < min_overlap:
        return Reason.LOW_OVERLAP
    if not fit.rms_mm <= max_rms_mm:
        return Reason.POOR_FIT
    if np.rad2deg(np.abs(transform.head_angles)).max() > max_angle_deg:
        return Reason.POSE
    return None
