"""ICP to the reference face, then the face's own symmetry and profile."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rangeface.errors import ParameterError
from rangeface.io.reference import default_reference
from rangeface.numerics import gaussian
from rangeface.numerics import icp as kernels
from rangeface.numerics.midline import midline, most_protruding
from rangeface.numerics.se3 import rotation_angle
from rangeface.register._icp import icp, pixel_weights
from rangeface.register._mirror import pooled, reflection, refusal, upright
from rangeface.types import Alignment, Face, Float64, RangeImage, ReferenceFace, RigidTransform

#: A mirror image that fits worse, or explains less of the face, gives no plane: mm, 0 … 1.
_MAX_MIRROR_RMS_MM, _MIN_MIRROR_OVERLAP = 5.0, 0.3
#: The nose tip is sought within this of where ICP put it.
_TIP_WITHIN_MM = 25.0
#: Half width of the ridge, length of it that is looked at, and σ of the smoothing, mm.
_RIDGE_MM, _REACH_MM, _SMOOTH_MM = 5.0, 35.0, 2.0


def symmetric(
    face: Face,
    *,
    reference: ReferenceFace | None = None,
    points: int = 1500,
    radius_mm: float = 90.0,
    max_rms_mm: float = 6.0,
    min_overlap: float = 0.3,
    min_correlation: float = 0.4,
    max_angle_deg: float = 70.0,
    max_change_deg: float = 15.0,
) -> Alignment:
    """Turn a face frontal by the reference face, then by its own symmetry and profile.

    A person is not the mean face: where ICP puts the frame depends on how they differ from it
    and on what is seen of them. Their plane of symmetry does not. ICP gives the pose; the
    mirror ICP, started there, gives yaw, roll and the middle; pitch stays ICP's. The nose tip is
    the most protruding point of the profile in the plane. Where the mirror image does not fit,
    the two disagree by too much, or the corrected pose no longer looks like the reference, the
    pose stays ICP's: `symmetric` refuses what `icp` refuses, and nothing else.

    Parameters
    ----------
    face : Face
        With a rough pose, or frontal within about 30°.
    reference : ReferenceFace, optional
        Default: the reference that ships with the package.
    points, max_rms_mm, min_overlap, min_correlation, max_angle_deg
        As for `icp`.
    radius_mm : float
        Points further from the nose tip take no part in the mirror image, > 0.
    max_change_deg : float
        The plane may turn ICP's pose by this much, ≥ 0.

    Returns
    -------
    Alignment
        `rms_mm`, `overlap`, `inliers` and `condition` are those of ICP; `correlation` is that
        of the corrected pose.

    Raises
    ------
    ParameterError
        As for `icp`; `radius_mm` ≤ 0, or `max_change_deg` < 0.

    Notes
    -----
    About twice the time of `icp`. The plane is figure 8 of the paper; the pitch of a head cannot
    be seen in it.
    """
    if not radius_mm > 0:
        raise ParameterError(f"radius_mm must be > 0, got {radius_mm}")
    if not max_change_deg >= 0:
        raise ParameterError(f"max_change_deg must be ≥ 0, got {max_change_deg}")
    reference = default_reference() if reference is None else reference
    found = icp(
        face, reference=reference, points=points, max_rms_mm=max_rms_mm, min_overlap=min_overlap,
        min_correlation=min_correlation, max_angle_deg=max_angle_deg,
    )  # fmt: skip
    if not found.converged:
        return found
    plane = _symmetry_plane(face, found.transform, radius_mm, max_angle_deg)
    if plane is None or _angle_deg(plane, found.transform) > max_change_deg:
        return found
    transform = _on_its_tip(face, plane)
    pose = transform.inverse()
    relief = kernels.relief(
        kernels.Model(*reference.surface(points)), pose.rotation, pose.translation,
        face.image.camera.projection, face.image.points,
    )  # fmt: skip
    if relief.correlation < min_correlation:
        return found
    return replace(found, transform=transform, correlation=relief.correlation)


def _symmetry_plane(
    face: Face, start: RigidTransform, radius_mm: float, max_angle_deg: float
) -> RigidTransform | None:
    """The start, turned upright on the symmetry plane; None where the halves do not show one."""
    points, projection = pooled(face)
    fit = reflection(points, projection, start, radius_mm)
    if fit is None or not np.isfinite(fit.moved_mm):
        return None
    pose = upright(fit, start)
    limits = (_MAX_MIRROR_RMS_MM, _MIN_MIRROR_OVERLAP, max_angle_deg)
    return None if refusal(fit, pose, *limits) else pose


def _angle_deg(one: RigidTransform, other: RigidTransform) -> float:
    return float(np.rad2deg(rotation_angle(one.rotation @ other.rotation.T)))


def _on_its_tip(face: Face, pose: RigidTransform) -> RigidTransform:
    """The pose, shifted in its middle plane until the most protruding point is the origin."""
    near = _around(face.image, pose.inverse().translation)
    if near is None:
        return pose
    # noise runs along the rays, oblique to the profile: smoothed before it is cut out
    width_px = _SMOOTH_MM / near.camera.pixel_mm(float(np.nanmedian(near.depth)))
    profile = midline(
        near.camera.back_project(gaussian.smooth(near.depth, width_px)),
        pixel_weights(replace(face, image=near)), pose.rotation, pose.translation,
        half_width_mm=_RIDGE_MM, reach_mm=_REACH_MM, smooth_mm=_SMOOTH_MM,
    )  # fmt: skip
    tip = most_protruding(profile, within_mm=_TIP_WITHIN_MM)
    if tip is None:
        return pose
    return RigidTransform(np.eye(3), np.array([0.0, -tip[0], -tip[1]]), source="face") @ pose


def _around(image: RangeImage, tip: Float64) -> RangeImage | None:
    """The window of an image about a point of the camera frame; None where most is outside it."""
    column, row = np.rint(np.nan_to_num(image.camera.project(tip), nan=-1e6)).astype(int)
    half = int(np.ceil(_REACH_MM / image.camera.pixel_mm(float(tip[2])))) + 1
    height, width = image.shape
    if not (0 <= column < width and 0 <= row < height):
        return None
    window = image.crop(int(column) - half, int(row) - half, 2 * half + 1, 2 * half + 1)
    return window if window.mask.any() and min(window.shape) >= half else None
