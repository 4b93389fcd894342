"""Robust point-to-plane ICP to the reference face, from several starts, with a self-check."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rangeface.errors import ParameterError
from rangeface.io.reference import default_reference
from rangeface.numerics import icp as kernels
from rangeface.numerics.pose_search import rotation_grid
from rangeface.register._outcome import outcome
from rangeface.types import Alignment, Face, Float32, Reason, ReferenceFace, RigidTransform

_GATES = np.array([25] * 3 + [18] * 3 + [12] * 4 + [10] * 12, np.float32)
_SCALES = np.array([9] * 3 + [6] * 3 + [4] * 4 + [3] * 12, np.float32)
#: Starts around the rough pose, tried only if the first one does not fit.
_MORE_STARTS = rotation_grid((-20.0, 0.0, 20.0), (-15.0, 0.0, 15.0), (-12.0, 0.0, 12.0))


def icp(
    face: Face,
    *,
    reference: ReferenceFace | None = None,
    points: int = 1500,
    max_rms_mm: float = 6.0,
    min_overlap: float = 0.3,
    min_correlation: float = 0.4,
    max_angle_deg: float = 70.0,
) -> Alignment:
    """Turn a face frontal by aligning the reference face to it.

    The reference's points are projected into the image and moved by Gauss–Newton steps on
    point-to-plane distances, weighted by 1/σ² and by how little people differ there, with a
    robust loss whose scale falls. If the result does not look like a face, other starts around
    the rough pose are tried; if none does, the face is refused.

    Parameters
    ----------
    face : Face
        With a rough pose, or frontal within about 30°.
    reference : ReferenceFace, optional
        Default: the reference that ships with the package.
    points : int
        About this many points of the reference are used, ≥ 100.
    max_rms_mm : float
        A larger residual of the inliers is refused.
    min_overlap : float
        0 … 1: less of the visible reference explained is refused.
    min_correlation : float
        −1 … 1: a smaller correlation of the reliefs is refused (smooth surfaces have none).
    max_angle_deg : float
        A head turned further than this is refused.

    Returns
    -------
    Alignment
        `converged` False with a reason if refused; never an identity in disguise.

    Raises
    ------
    ParameterError
        `points` < 100 or `max_angle_deg` ≤ 0.

    References
    ----------
    P. Besl, N. McKay, IEEE TPAMI 14(2), 1992, doi:10.1109/34.121791; Y. Chen, G. Medioni, 1991,
    doi:10.1109/ROBOT.1991.132043 (point to plane); Rusinkiewicz and Levoy, 2001,
    doi:10.1109/IM.2001.924423 (variants).
    """
    if points < 100:
        raise ParameterError(f"points must be ≥ 100, got {points}")
    if not max_angle_deg > 0:
        raise ParameterError(f"max_angle_deg must be > 0, got {max_angle_deg}")
    reference = default_reference() if reference is None else reference
    model = kernels.Model(*reference.surface(points))
    limits = (max_rms_mm, min_overlap, min_correlation, max_angle_deg)
    start = _start(face)
    best = _attempt(face, model, start.rotation, start.translation, limits)
    if not best.converged:
        for turn in _MORE_STARTS:
            other = _attempt(face, model, turn @ start.rotation, start.translation, limits)
            if _quality(other) > _quality(best):
                best = other
    return best


def _start(face: Face) -> RigidTransform:
    """Rough pose camera←face."""
    if face.pose is not None:
        return face.pose.inverse()
    return RigidTransform(np.eye(3), face.nose_tip, target="camera", source="face")


def _attempt(
    face: Face,
    model: kernels.Model,
    rotation: np.ndarray,
    translation: np.ndarray,
    limits: tuple[float, float, float, float],
) -> Alignment:
    image, projection = face.image, face.image.camera.projection
    fit = kernels.align(
        model, projection, image.points, pixel_weights(face), rotation, translation,
        gates_mm=_GATES, scales_mm=_SCALES,
    )  # fmt: skip
    correlation = kernels.relief(
        model, fit.rotation, fit.translation, projection, image.points
    ).correlation
    pose = RigidTransform(_proper(fit.rotation), fit.translation, target="camera", source="face")
    transform = pose.inverse()
    reason = refusal(fit, correlation, transform, *limits)
    return replace(outcome(fit, transform, reason), correlation=correlation)


def pixel_weights(face: Face) -> Float32:
    """1/σ² of each pixel, scaled to a median of 1; ones where σ is unknown."""
    sigma = face.image.sigma
    if sigma is None:
        return np.ones(face.image.shape, np.float32)
    usable = face.image.mask & np.isfinite(sigma) & (sigma > 0)
    if not usable.any():
        return np.ones(face.image.shape, np.float32)
    floor = 0.25 * float(np.median(sigma[usable]))  # no pixel weighs more than 16 of the median
    weights = np.where(usable, 1.0 / np.maximum(np.nan_to_num(sigma, nan=1e6), floor) ** 2, 0.0)
    return (weights / np.median(weights[usable])).astype(np.float32)


def refusal(
    fit: kernels.Fit,
    correlation: float,
    transform: RigidTransform,
    max_rms_mm: float,
    min_overlap: float,
    min_correlation: float,
    max_angle_deg: float,
) -> Reason | None:
    if fit.inliers < 60:
        return Reason.TOO_FEW_POINTS
    if not fit.moved_mm < 1.0 or fit.condition > 1e5:
        return Reason.NOT_CONVERGED
    if fit.overlap < min_overlap:
        return Reason.LOW_OVERLAP
    if not fit.rms_mm <= max_rms_mm or correlation < min_correlation:
        return Reason.POOR_FIT
    if np.rad2deg(np.abs(transform.head_angles)).max() > max_angle_deg:
        return Reason.POSE
    return None


def _quality(alignment: Alignment) -> float:
    return (1.0 if alignment.converged else 0.0) + alignment.overlap * alignment.correlation


def _proper(rotation: np.ndarray) -> np.ndarray:
    """The nearest rotation: many float steps drift from orthonormality."""
    U, _, Vt = np.linalg.svd(rotation)
    return U @ Vt
