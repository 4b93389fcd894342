r"""Point-to-plane ICP of a model surface against an organised range image.

The model's points are projected into the image (projective association, Blais and Levine,
doi:10.1109/34.400574), so that an iteration costs the same whatever the size of the image
and no search tree is built. Minimised is, over the pose :math:`T = (R, t)` camera←model,

.. math:: E(T) = \sum_k w_k \, ρ\big( (R n_k) · (q_k - R p_k - t) \big)

with the model's points :math:`p_k` and normals :math:`n_k`, the image's point :math:`q_k` in
the pixel that :math:`R p_k + t` falls into, and the Geman–McClure loss ρ, whose scale falls
from iteration to iteration (coarse to fine).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.numerics.projection import Projection

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}
#: A model point that faces away by more than this cosine is invisible.
_GRAZING = 0.15


class Model(NamedTuple):
    """A surface as points (m, 3) mm, unit normals (m, 3) and weights (m,), all float32."""

    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    weights: NDArray[np.float32]

    def sized(self, factor: float) -> Model:
        """The model scaled about its origin."""
        return Model(self.points * np.float32(factor), self.normals, self.weights)


class Fit(NamedTuple):
    """Result of `align`.

    Attributes
    ----------
    rotation : (3, 3) float64
        R, camera←model.
    translation : (3,) float64
        t, mm.
    rms_mm : float
        Root of the weighted mean square residual of the inliers; NaN without inliers.
    overlap : float
        0 … 1: weight of the inliers over the weight of what should be visible.
    inliers : int
        Model points with a residual below the gate.
    condition : float
        Condition number of the normal equations, rotations scaled by `ARM_MM`.
    moved_mm : float
        Length of the last step (rotation times `ARM_MM` plus translation): 0 = converged.
    """

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]
    rms_mm: float
    overlap: float
    inliers: int
    condition: float
    moved_mm: float


#: Lever that makes a rotation comparable with a translation: about the radius of a face.
ARM_MM = 60.0


#: What the projection of a model point meets.
_HIDDEN, _MISSING, _PAIRED = 0, 1, 2


@njit(cache=True, nogil=True, fastmath=_FASTMATH, inline="always")
def _pair(model, k, R, t, projection, image):  # type: ignore[no-untyped-def]
    """Pose model point k, find its pixel, and measure the offset to the image's point there.

    Returns a status, the posed point, the posed normal, the offset, row and column. A point that
    faces away is hidden; one that meets a hole or the image's border is missing.
    """
    points, normals, _ = model
    perspective, sx, sy, cx, cy = projection
    px, py, pz = points[k, 0], points[k, 1], points[k, 2]
    mx, my, mz = normals[k, 0], normals[k, 1], normals[k, 2]
    x = R[0, 0] * px + R[0, 1] * py + R[0, 2] * pz + t[0]
    y = R[1, 0] * px + R[1, 1] * py + R[1, 2] * pz + t[1]
    z = R[2, 0] * px + R[2, 1] * py + R[2, 2] * pz + t[2]
    nx = R[0, 0] * mx + R[0, 1] * my + R[0, 2] * mz
    ny = R[1, 0] * mx + R[1, 1] * my + R[1, 2] * mz
    nz = R[2, 0] * mx + R[2, 1] * my + R[2, 2] * mz
    none = np.float32(0.0)
    facing, scale = -nz, np.float32(1.0)
    if perspective:
        scale = np.float32(1.0) / max(z, np.float32(1.0))
        facing = -(x * nx + y * ny + z * nz) / math.sqrt(x * x + y * y + z * z)
    if facing < _GRAZING or (perspective and z <= 1.0):
        return _HIDDEN, x, y, z, nx, ny, nz, none, none, none, 0, 0
    u = sx * x * scale + cx + np.float32(0.5)
    v = sy * y * scale + cy + np.float32(0.5)
    if not (u >= 0.0 and v >= 0.0 and u < image.shape[1] and v < image.shape[0]):
        return _MISSING, x, y, z, nx, ny, nz, none, none, none, 0, 0
    row, col = int(v), int(u)
    dx, dy, dz = image[row, col, 0] - x, image[row, col, 1] - y, image[row, col, 2] - z
    status = _PAIRED if dz == dz else _MISSING  # NaN: the pixel is invalid
    return status, x, y, z, nx, ny, nz, dx, dy, dz, row, col


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _accumulate(  # type: ignore[no-untyped-def]
    model, R, t, projection, image, image_weights, gate, scale, A, b
):
    """Fill the 6 × 6 normal equations; return Σw, Σw r², visible and explained weight, inliers."""
    weights = model[2]
    A[:] = 0.0
    b[:] = 0.0
    J = np.empty(6, np.float64)
    sum_w = sum_wr2 = visible = explained = 0.0
    inliers = 0
    s2 = scale * scale
    for k in range(weights.shape[0]):
        status, x, y, z, nx, ny, nz, dx, dy, dz, row, col = _pair(model, k, R, t, projection, image)
        if status == _HIDDEN:
            continue
        visible += weights[k]
        if status == _MISSING or dx * dx + dy * dy + dz * dz > gate * gate:
            continue
        r = nx * dx + ny * dy + nz * dz
        robust = s2 / (s2 + r * r)
        w = weights[k] * image_weights[row, col] * robust * robust
        x -= t[0]
        y -= t[1]
        z -= t[2]
        J[0], J[1], J[2] = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
        J[3], J[4], J[5] = nx, ny, nz
        for i in range(6):
            wj = w * J[i]
            b[i] += wj * r
            for j in range(i + 1):
                A[i, j] += wj * J[j]
        sum_w += w
        if r * r < s2:
            sum_wr2 += r * r
            explained += weights[k]
            inliers += 1
    for i in range(6):
        for j in range(i):
            A[j, i] = A[i, j]
    return sum_w, sum_wr2, visible, explained, inliers


@njit(cache=True, nogil=True)
def _turn(R, w):  # type: ignore[no-untyped-def]
    """Exp([w]×) R by Rodrigues' formula."""
    angle = math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if angle < 1e-12:
        return R.copy()
    x, y, z = w[0] / angle, w[1] / angle, w[2] / angle
    c, s = math.cos(angle), math.sin(angle)
    k = 1.0 - c
    D = np.array(
        [
            [c + x * x * k, x * y * k - z * s, x * z * k + y * s],
            [y * x * k + z * s, c + y * y * k, y * z * k - x * s],
            [z * x * k - y * s, z * y * k + x * s, c + z * z * k],
        ]
    )
    return D @ R


@njit(cache=True, nogil=True)
def _iterate(  # type: ignore[no-untyped-def]
    model, R, t, projection, image, image_weights, gates, scales, tolerance
):
    """Gauss–Newton over the schedule of gates and scales; at the last scale, until it rests."""
    A = np.zeros((6, 6))
    b = np.zeros(6)
    moved = np.inf
    for k in range(gates.shape[0]):
        sum_w = _accumulate(
            model, R.astype(np.float32), t.astype(np.float32), projection, image, image_weights,
            gates[k], scales[k], A, b,
        )[0]  # fmt: skip
        if sum_w <= 0.0:
            return R, t, np.inf
        # a trace of damping: what the surface leaves open (a sphere's spin) stays where it is
        damping = 1e-4 * (A[3, 3] + A[4, 4] + A[5, 5])
        for i in range(3):
            A[i, i] += damping * ARM_MM * ARM_MM
            A[3 + i, 3 + i] += damping
        step = np.linalg.solve(A, b)
        R = _turn(R, step[:3])
        t = t + step[3:]
        moved = ARM_MM * math.sqrt((step[:3] ** 2).sum()) + math.sqrt((step[3:] ** 2).sum())
        if scales[k] == scales[-1] and moved < tolerance:
            break
    return R, t, moved


def align(
    model: Model,
    projection: Projection,
    image: NDArray[np.float32],
    image_weights: NDArray[np.float32],
    rotation: NDArray[np.float64],
    translation: NDArray[np.float64],
    *,
    gates_mm: NDArray[np.float32],
    scales_mm: NDArray[np.float32],
    tolerance_mm: float = 0.02,
) -> Fit:
    """Move a model onto an organised range image, from one start.

    Parameters
    ----------
    model : Model
        Points, normals (towards the camera when frontal) and weights.
    projection : Projection
        Of the image's camera.
    image : (H, W, 3) float32
        Points of the image, mm, NaN where invalid.
    image_weights : (H, W) float32
        Weight of each pixel, ≥ 0, finite; 1/σ² up to a factor.
    rotation, translation : (3, 3), (3,) float64
        Start of R, t (camera←model).
    gates_mm, scales_mm : (k,) float32
        For each iteration, the largest distance of a pair and the scale of the loss, mm.
    tolerance_mm : float
        At the last scale, a step shorter than this ends the iteration.

    Returns
    -------
    Fit
        The pose and how well it is known; `inliers` 0 if nothing could be associated.
    """
    gates = np.asarray(gates_mm, np.float32)
    scales = np.asarray(scales_mm, np.float32)
    R, t, moved = _iterate(
        tuple(model), np.asarray(rotation, np.float64), np.asarray(translation, np.float64),
        tuple(projection), image, image_weights, gates, scales, tolerance_mm,
    )  # fmt: skip
    A, b = np.zeros((6, 6)), np.zeros(6)
    _, sum_r2, visible, explained, inliers = _accumulate(
        tuple(model), R.astype(np.float32), t.astype(np.float32), tuple(projection),
        image, image_weights, gates[-1], scales[-1], A, b,
    )  # fmt: skip
    return Fit(
        rotation=R,
        translation=t,
        rms_mm=math.sqrt(sum_r2 / inliers) if inliers else math.nan,
        overlap=explained / visible if visible > 0 else 0.0,
        inliers=int(inliers),
        condition=condition(A),
        moved_mm=float(moved),
    )


def condition(A: NDArray[np.float64]) -> float:
    """Condition number of normal equations (6, 6), rotations taken at the arm of a head."""
    lever = np.array([ARM_MM] * 3 + [1.0] * 3)
    values = np.linalg.eigvalsh(A / np.outer(lever, lever))
    return float(values[-1] / max(values[0], 1e-12 * max(values[-1], 1e-30)))


@njit(cache=True, nogil=True)
def _align_many(  # type: ignore[no-untyped-def]
    model, rotations, translations, projection, image, image_weights, gates, scales
):
    out_R = np.empty_like(rotations)
    out_t = np.empty_like(translations)
    for k in range(rotations.shape[0]):
        out_R[k], out_t[k], _ = _iterate(
            model, rotations[k], translations[k], projection, image, image_weights,
            gates, scales, 0.1,
        )  # fmt: skip
    return out_R, out_t


def align_many(
    model: Model,
    projection: Projection,
    image: NDArray[np.float32],
    image_weights: NDArray[np.float32],
    rotations: NDArray[np.float64],
    translations: NDArray[np.float64],
    *,
    gates_mm: NDArray[np.float32],
    scales_mm: NDArray[np.float32],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where `align` leads from each of n starts, without the statistics.

    Parameters
    ----------
    model, projection, image, image_weights, gates_mm, scales_mm
        As in `align`.
    rotations, translations : (n, 3, 3), (n, 3) float64
        Starts.

    Returns
    -------
    rotations, translations : (n, 3, 3), (n, 3) float64
    """
    return _align_many(
        tuple(model), rotations, translations, tuple(projection), image, image_weights,
        gates_mm, scales_mm,
    )  # fmt: skip


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _scores(model, rotations, translations, projection, image, tolerance):  # type: ignore[no-untyped-def]
    weights = model[2]
    out = np.empty(rotations.shape[0], np.float32)
    total = weights.sum()
    for h in range(rotations.shape[0]):
        R, t = rotations[h], translations[h]
        visible = explained = np.float32(0.0)
        for k in range(weights.shape[0]):
            status, _, _, _, nx, ny, nz, dx, dy, dz, _, _ = _pair(model, k, R, t, projection, image)
            if status == _HIDDEN:
                continue
            visible += weights[k]
            if status == _MISSING:
                continue
            r = (nx * dx + ny * dy + nz * dz) / tolerance
            along = (dx * dx + dy * dy + dz * dz) / (16.0 * tolerance * tolerance)
            if r * r < 1.0 and along < 1.0:
                explained += weights[k] * (np.float32(1.0) - r * r)
        # a pose that hides most of the model cannot score well by the little that is left
        out[h] = explained / max(visible, np.float32(0.5) * total)
    return out


def scores(
    model: Model,
    rotations: NDArray[np.float64],
    translations: NDArray[np.float64],
    projection: Projection,
    image: NDArray[np.float32],
    *,
    tolerance_mm: float,
) -> NDArray[np.float32]:
    """How much of the model the image explains, in each of n poses.

    Parameters
    ----------
    model : Model
        Few points (60 … 200) suffice for a search.
    rotations, translations : (n, 3, 3), (n, 3)
        Poses camera←model.
    projection : Projection
        Of the image's camera.
    image : (H, W, 3) float32
        Points of the image, mm, NaN where invalid.
    tolerance_mm : float
        Distance at which a point no longer counts, mm.

    Returns
    -------
    (n,) float32
        0 … 1.
    """
    return _scores(
        tuple(model), np.asarray(rotations, np.float32), np.asarray(translations, np.float32),
        tuple(projection), image, np.float32(tolerance_mm),
    )  # fmt: skip


class Evidence(NamedTuple):
    """What an image says about a model in a pose; weights of points over that of all of them.

    Attributes
    ----------
    visible : float
        Points that face the camera.
    explained : float
        Those near the image's surface, less the nearer the tolerance they are.
    missing : float
        Those that meet no measurement.
    behind : float
        Those where the camera sees through the model to a surface far behind it.
    before : float
        Those hidden by a surface far before the model.
    """

    visible: float
    explained: float
    missing: float
    behind: float
    before: float


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _evidence(model, R, t, projection, image, tolerance):  # type: ignore[no-untyped-def]
    weights = model[2]
    total = visible = explained = missing = behind = before = 0.0
    for k in range(weights.shape[0]):
        w = weights[k]
        total += w
        status, _, _, _, nx, ny, nz, dx, dy, dz, _, _ = _pair(model, k, R, t, projection, image)
        if status == _HIDDEN:
            continue
        visible += w
        if status == _MISSING:
            missing += w
            continue
        r = (nx * dx + ny * dy + nz * dz) / tolerance
        along = (dx * dx + dy * dy + dz * dz) / (16.0 * tolerance * tolerance)
        if r * r < 1.0 and along < 1.0:
            explained += w * (1.0 - r * r)
        elif r < -2.0:
            behind += w
        elif r > 2.0:
            before += w
    return visible / total, explained / total, missing / total, behind / total, before / total


def evidence(
    model: Model,
    rotation: NDArray[np.float64],
    translation: NDArray[np.float64],
    projection: Projection,
    image: NDArray[np.float32],
    *,
    tolerance_mm: float,
) -> Evidence:
    """What the image says for and against one pose.

    Parameters
    ----------
    model, rotation, translation, projection, image, tolerance_mm
        As in `scores`, for a single pose.

    Returns
    -------
    Evidence
    """
    return Evidence(
        *_evidence(
            tuple(model), np.asarray(rotation, np.float32), np.asarray(translation, np.float32),
            tuple(projection), image, np.float32(tolerance_mm),
        )
    )  # fmt: skip


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _correspondences(model, R, t, projection, image, gate):  # type: ignore[no-untyped-def]
    points = model[0]
    out = np.full(points.shape, np.nan, np.float32)
    for k in range(points.shape[0]):
        status, _, _, _, _, _, _, dx, dy, dz, _, _ = _pair(model, k, R, t, projection, image)
        if status == _PAIRED and dx * dx + dy * dy + dz * dz < gate * gate:
            for i in range(3):
                out[k, i] = points[k, i] + R[0, i] * dx + R[1, i] * dy + R[2, i] * dz
    return out


class Relief(NamedTuple):
    """An image's surface against a model's, each split into its best quadric and the rest.

    Attributes
    ----------
    correlation : float
        −1 … 1, of the rests: nose, eye sockets, lips.
    steepness : float
        Slope of the regression of the image's rest on the model's: 1 for relief as high as the
        model's. Noise lowers the correlation, not the slope.
    bend : float
        Distance of the quadrics' second-order coefficients, mm at `ARM_MM` from the origin.
    """

    correlation: float
    steepness: float
    bend: float


def relief(
    model: Model,
    rotation: NDArray[np.float64],
    translation: NDArray[np.float64],
    projection: Projection,
    image: NDArray[np.float32],
    *,
    gate_mm: float = 20.0,
) -> Relief:
    r"""Compare the image's relief with the model's, both without their own quadric.

    A smooth surface (shoulder, cushion, ball) lies close to a face almost everywhere; it has
    no nose. What remains after the best quadric :math:`z = (1, x, y, x^2, xy, y^2) β` is the
    relief.

    Parameters
    ----------
    model, rotation, translation, projection, image
        As in `align`.
    gate_mm : float
        Pairs further apart are left out.

    Returns
    -------
    Relief
        All 0 if fewer than 30 points are paired.
    """
    found = _correspondences(
        tuple(model), np.asarray(rotation, np.float32), np.asarray(translation, np.float32),
        tuple(projection), image, np.float32(gate_mm),
    )  # fmt: skip
    return Relief(*_relief(found, model.points, model.weights))


@njit(cache=True, nogil=True)
def _relief(found, points, weights):  # type: ignore[no-untyped-def]
    paired = 0
    for k in range(found.shape[0]):
        paired += found[k, 2] == found[k, 2]
    if paired < 30:
        return 0.0, 0.0, 0.0
    alpha, beta = _quadric(found, found, weights), _quadric(points, found, weights)
    aa = bb = ab = 0.0
    for k in range(found.shape[0]):
        if found[k, 2] == found[k, 2]:
            a, b = _above(alpha, found, k), _above(beta, points, k)
            aa += weights[k] * a * a
            bb += weights[k] * b * b
            ab += weights[k] * a * b
    bend = abs(alpha[3] - beta[3]) + abs(alpha[4] - beta[4]) + abs(alpha[5] - beta[5])
    return ab / max(math.sqrt(aa * bb), 1e-12), ab / max(bb, 1e-12), bend


@njit(cache=True, nogil=True)
def _quadric(points, found, weights):  # type: ignore[no-untyped-def]
    """β of the best z = (1, x, y, x², xy, y²) β through the paired points; x, y in `ARM_MM`."""
    A, b, row = np.zeros((6, 6)), np.zeros(6), np.empty(6)
    for k in range(points.shape[0]):
        if found[k, 2] != found[k, 2]:
            continue
        x, y, z = points[k, 0] / ARM_MM, points[k, 1] / ARM_MM, points[k, 2]
        row[0], row[1], row[2], row[3], row[4], row[5] = 1.0, x, y, x * x, x * y, y * y
        for i in range(6):
            w = weights[k] * row[i]
            b[i] += w * z
            for j in range(6):
                A[i, j] += w * row[j]
    trace = np.trace(A)
    for i in range(6):
        A[i, i] += 1e-9 * trace
    return np.linalg.solve(A, b)


@njit(cache=True, nogil=True, inline="always")
def _above(beta, points, k):  # type: ignore[no-untyped-def]
    x, y = points[k, 0] / ARM_MM, points[k, 1] / ARM_MM
    flat = beta[0] + beta[1] * x + beta[2] * y
    return points[k, 2] - flat - beta[3] * x * x - beta[4] * x * y - beta[5] * y * y
