r"""Point-to-plane ICP of an unorganised cloud and a model surface, by a k-d tree.

For clouds that no camera ordered, where `numerics.icp` cannot project. The tree is built over the
model, whose normals are clean; minimised is, over the pose (R, t) cloud←model,

.. math:: E = \sum_i ρ\big( n_{k(i)} · (R^T (q_i - t) - p_{k(i)}) \big)

with k(i) the model point nearest to the cloud's point :math:`q_i`, seen from the model's frame,
and the Geman–McClure loss ρ.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from rangeface.numerics.icp import ARM_MM, Fit, Model, condition
from rangeface.numerics.se3 import rotation_matrix

Float64: TypeAlias = NDArray[np.float64]


def align(
    model: Model,
    tree: cKDTree,
    cloud: Float64,
    rotation: Float64,
    translation: Float64,
    *,
    gates_mm: NDArray[np.float32],
    scales_mm: NDArray[np.float32],
    tolerance_mm: float = 0.02,
) -> Fit:
    """Move a model onto an unorganised cloud, from one start.

    Parameters
    ----------
    model : Model
        Points, normals and weights.
    tree : cKDTree
        Over the model's points; build it once for many clouds.
    cloud : (n, 3) float64
        Points, mm, finite.
    rotation, translation : (3, 3), (3,) float64
        Start of R, t (cloud←model).
    gates_mm, scales_mm : (k,) float32
        For each iteration, the largest distance of a pair and the scale of the loss, mm.
    tolerance_mm : float
        At the last scale, a step shorter than this ends the iteration.

    Returns
    -------
    Fit
        `overlap` is the share of the model's weight that some point of the cloud explains.
    """
    R, t, moved = np.array(rotation, np.float64), np.array(translation, np.float64), math.inf
    for gate, scale in zip(gates_mm, scales_mm, strict=True):
        J, r, w, _ = _pairs(model, tree, cloud, R, t, float(gate), float(scale))
        if len(r) < 6:
            return Fit(R, t, math.nan, 0.0, 0, math.inf, math.inf)
        A = (J * w[:, None]).T @ J
        damping = 1e-4 * np.trace(A[3:, 3:])
        A += damping * np.diag([ARM_MM**2] * 3 + [1.0] * 3)
        step = np.linalg.solve(A, J.T @ (w * r))
        # the step moves the cloud in the model's frame: x → exp(ω) x + v; the pose takes it back
        turn = rotation_matrix(step[:3])
        R, t = R @ turn.T, t - R @ turn.T @ step[3:]
        moved = ARM_MM * float(np.linalg.norm(step[:3])) + float(np.linalg.norm(step[3:]))
        if scale == scales_mm[-1] and moved < tolerance_mm:
            break
    return _fit(model, tree, cloud, R, t, moved, float(gates_mm[-1]), float(scales_mm[-1]))


def _pairs(
    model: Model, tree: cKDTree, cloud: Float64, R: Float64, t: Float64, gate: float, scale: float
) -> tuple[Float64, Float64, Float64, NDArray[np.intp]]:
    """Jacobian rows, residuals, weights and model indices of all pairs within the gate."""
    x = (cloud - t) @ R
    distance, nearest = tree.query(x, distance_upper_bound=gate)
    paired = np.isfinite(distance)
    x, k = x[paired], nearest[paired]
    n = model.normals[k].astype(np.float64)
    r = ((model.points[k] - x) * n).sum(axis=1)
    w = model.weights[k] * (scale**2 / (scale**2 + r * r)) ** 2
    return np.hstack([np.cross(x, n), n]), r, w, k


def _fit(
    model: Model, tree: cKDTree, cloud: Float64, R: Float64, t: Float64, moved: float,
    gate: float, scale: float,
) -> Fit:  # fmt: skip
    J, r, w, k = _pairs(model, tree, cloud, R, t, gate, scale)
    near = np.abs(r) < scale
    if not near.any():
        return Fit(R, t, math.nan, 0.0, 0, math.inf, moved)
    explained = np.zeros(len(model.weights), bool)
    explained[k[near]] = True
    return Fit(
        rotation=R,
        translation=t,
        rms_mm=float(np.sqrt(np.mean(r[near] ** 2))),
        overlap=float(model.weights[explained].sum() / model.weights.sum()),
        inliers=int(near.sum()),
        condition=condition((J * w[:, None]).T @ J),
        moved_mm=moved,
    )
