"""The face of the last frame, found again in the next one."""

from __future__ import annotations

import numpy as np

from rangeface.errors import ParameterError
from rangeface.io.reference import default_reference
from rangeface.numerics import icp
from rangeface.numerics.pose_search import rotation_grid
from rangeface.segment._confidence import confidence, cues
from rangeface.segment._crop import around, face_at
from rangeface.segment._slices import pooled, protruding
from rangeface.types import Faces, RangeImage, Reason, ReferenceFace, RigidTransform

#: A head turns by less than this between two frames, or ICP closes the rest.
_TURNS = rotation_grid((-15.0, 0.0, 15.0), (-12.0, 0.0, 12.0), (0.0,))
_GATES = np.array([25, 20, 15, 12, 12, 10, 10], np.float32)
_SCALES = np.array([10, 8, 6, 5, 5, 4, 4], np.float32)
#: So many of the scored poses are refined.
_REFINED = 4


def follow(
    image: RangeImage,
    pose: RigidTransform,
    *,
    reference: ReferenceFace | None = None,
    radius_mm: float = 140.0,
    max_step_mm: float = 80.0,
    min_confidence: float = 0.3,
) -> Faces:
    """Find the face of the last frame again, without a search of the whole image.

    Only the surroundings of the last place are looked at. The last pose, some turned a little
    from it, and the points nearby that protrude along the head's axis are scored against the
    reference face; the best are refined by ICP and verified as `slices` does it.

    Parameters
    ----------
    image : RangeImage
        The next frame, from the same camera at the same place.
    pose : RigidTransform
        T_face_camera of the last frame, from its `Alignment` or `Face`.
    reference : ReferenceFace, optional
        Default: the reference that ships with the package.
    radius_mm : float
        Radius of the sphere crop, > 0.
    max_step_mm : float
        A nose tip further than this from its last place is another one's, > 0.
    min_confidence : float
        0 … 1: as in `slices`, but lower: where a face was, a face is likely. Below, it is lost.

    Returns
    -------
    Faces
        One face; or none, with the reason: lost, or no valid pixel at all.

    Raises
    ------
    ParameterError
        A parameter is out of range, or the pose does not lead from the camera to the face.
    """
    _check(pose, radius_mm, max_step_mm, min_confidence)
    reference = default_reference() if reference is None else reference
    last = pose.inverse()
    near = around(image, last.translation, radius_mm + max_step_mm)
    if not near.mask.any():
        return Faces(reason=Reason.LOST if image.mask.any() else Reason.NO_VALID_PIXELS)
    found, confidence = _pose_near(near, last, reference, max_step_mm)
    step_mm = float(np.linalg.norm(found.translation - last.translation))
    if confidence < min_confidence or step_mm > max_step_mm:
        return Faces(reason=Reason.LOST)
    return Faces([face_at(near, reference, found, confidence, radius_mm)])


def _pose_near(
    image: RangeImage, last: RigidTransform, reference: ReferenceFace, max_step_mm: float
) -> tuple[RigidTransform, float]:
    """The best pose (camera←face) about the last one, and its confidence."""
    view, pixel_mm = pooled(image, float(last.translation[2]))
    rough, close = icp.Model(*reference.surface(80)), icp.Model(*reference.surface(400))
    tips, _ = protruding(view.points, last.rotation[None], pixel_mm)
    reached = np.linalg.norm(tips - last.translation, axis=1) <= max_step_mm
    tips = np.vstack([last.translation, tips[reached]])
    turned = last.rotation @ _TURNS
    R = np.tile(turned, (len(tips), 1, 1))
    t = np.repeat(tips, len(turned), axis=0)
    scores = icp.scores(rough, R, t, view.projection, view.points, tolerance_mm=12.0)
    best = np.argsort(-scores, kind="stable")[:_REFINED]
    R, t = icp.align_many(
        close, view.projection, view.points, view.weights, R[best], t[best],
        gates_mm=_GATES, scales_mm=_SCALES,
    )  # fmt: skip
    sure = [
        confidence(cues(close, R_k, t_k, view.projection, view.points))
        for R_k, t_k in zip(R, t, strict=True)
    ]
    k = int(np.argmax(sure))
    return RigidTransform(R[k], t[k], target=last.target, source=last.source), sure[k]


def _check(
    pose: RigidTransform, radius_mm: float, max_step_mm: float, min_confidence: float
) -> None:
    if (pose.target, pose.source) != ("face", "camera"):
        raise ParameterError(
            f"pose must lead face←camera, got {pose.target}←{pose.source}; use its inverse"
        )
    if not radius_mm > 0:
        raise ParameterError(f"radius_mm must be > 0, got {radius_mm}")
    if not max_step_mm > 0:
        raise ParameterError(f"max_step_mm must be > 0, got {max_step_mm}")
    if not 0 <= min_confidence <= 1:
        raise ParameterError(f"min_confidence must lie in 0 … 1, got {min_confidence}")
