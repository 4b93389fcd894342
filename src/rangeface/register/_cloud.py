"""ICP to the reference face for points that no camera ordered."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from rangeface.io.reference import default_reference
from rangeface.numerics import icp_cloud
from rangeface.numerics.icp import Model
from rangeface.register._icp import refusal
from rangeface.register._outcome import outcome
from rangeface.types import Alignment, PointSet, ReferenceFace, RigidTransform

_GATES = np.array([30] * 4 + [20] * 4 + [12] * 4 + [10] * 18, np.float32)
_SCALES = np.array([9] * 4 + [6] * 4 + [4] * 4 + [3] * 18, np.float32)


def cloud(
    points: PointSet,
    start: RigidTransform,
    *,
    reference: ReferenceFace | None = None,
    radius_mm: float = 120.0,
    max_rms_mm: float = 6.0,
    min_overlap: float = 0.3,
    max_angle_deg: float = 70.0,
) -> Alignment:
    """Turn an unorganised cloud frontal by point-to-plane ICP with a k-d tree.

    Slower than `icp` by an order of magnitude; use it where there is no camera, and so no pixel
    to project into.

    Parameters
    ----------
    points : PointSet
        A face and what is around it.
    start : RigidTransform
        T_face_camera, right within about 15° and 20 mm.
    reference : ReferenceFace, optional
        Default: the reference that ships with the package.
    radius_mm : float
        Points further from the start's nose tip are left out, > 0.
    max_rms_mm, min_overlap, max_angle_deg : float
        Limits of refusal, as in `icp`; the overlap counts what no camera could see, too.

    Returns
    -------
    Alignment
        `converged` False with a reason if refused. The correlation of reliefs is not known.
    """
    reference = default_reference() if reference is None else reference
    model, tree = _surface(reference)
    first = start.inverse()
    near = np.linalg.norm(points.points - first.translation, axis=1) <= radius_mm
    chosen = points.points[near].astype(np.float64)
    fit = icp_cloud.align(
        model, tree, chosen, first.rotation, first.translation, gates_mm=_GATES, scales_mm=_SCALES
    )
    transform = RigidTransform(fit.rotation, fit.translation, "camera", "face").inverse()
    reason = refusal(fit, 1.0, transform, max_rms_mm, min_overlap, 0.0, max_angle_deg)
    return outcome(fit, transform, reason)


@lru_cache(maxsize=4)
def _surface(reference: ReferenceFace) -> tuple[Model, cKDTree]:
    model = Model(*reference.surface(4000))
    return model, cKDTree(model.points)
