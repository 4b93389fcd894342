"""Range slices, connected regions, and in each region the pose that looks most like a face."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError
from rangeface.io.reference import default_reference
from rangeface.numerics import icp
from rangeface.numerics.pose_search import pool, protrusions, rotation_grid
from rangeface.numerics.projection import Projection
from rangeface.numerics.se3 import head_angles
from rangeface.segment._confidence import confidence, cues
from rangeface.segment._crop import face_at
from rangeface.types import (
    Faces,
    Float32,
    Float64,
    Mask,
    RangeImage,
    Reason,
    ReferenceFace,
    RigidTransform,
    revision,
)

Indices: TypeAlias = NDArray[np.intp]

#: A face covers at least this (mm²) even when turned to a half profile.
_MIN_AREA_MM2 = 4000.0
#: Pixels are pooled to about this width before the search: noise falls, a nose stays.
_SEARCH_PIXEL_MM = 4.0
_PITCHES_DEG = (-40.0, -20.0, 0.0, 20.0, 40.0)
_ROLLS_DEG = (-25.0, 0.0, 25.0)
#: The nose tips of two people are further apart than this; a chin or collar is nearer to its own.
_APART_MM = 200.0
#: A refined pose may leave the searched range by this much.
_STRAY_DEG = 15.0
#: Where the reference finds nothing sure, a smaller one is tried: faces differ in size.
_SIZES = (1.0, 0.88)
_SURE = 0.9
_GATES = np.array([30, 25, 20, 20, 15, 15, 12, 12, 10, 10], np.float32)
_SCALES = np.array([12, 10, 8, 8, 6, 6, 5, 5, 4, 4], np.float32)


class View(NamedTuple):
    """An image at the resolution of the search: points, weights of the pixels, projection."""

    points: Float32
    weights: Float32
    projection: Projection


class _Hypothesis(NamedTuple):
    score: float
    rotation: Float64
    translation: Float64

    @property
    def pose(self) -> RigidTransform:
        return RigidTransform(self.rotation, self.translation, target="camera", source="face")


@revision(2)
def slices(
    image: RangeImage,
    *,
    reference: ReferenceFace | None = None,
    radius_mm: float = 140.0,
    min_gap_mm: float = 60.0,
    max_yaw_deg: float = 60.0,
    max_faces: int = 8,
    min_confidence: float = 0.5,
) -> Faces:
    """Find the faces of an image: slice by range, connect, search each region, crop by a sphere.

    The histogram of depth is cut at its valleys; each slice is opened and split into connected
    regions. In a region, every point that protrudes along some viewing axis is a candidate for
    the nose tip; candidates × yaw × pitch × roll are scored against the reference face, the
    best are refined by ICP and verified: fit, relief, and what contradicts a face give its
    confidence. What remains is cropped by a sphere around its nose tip.

    Parameters
    ----------
    image : RangeImage
        Any camera.
    reference : ReferenceFace, optional
        Default: the reference that ships with the package.
    radius_mm : float
        Radius of the sphere crop, > 0.
    min_gap_mm : float
        Slices are cut where the histogram of depth is empty over this length, > 0.
    max_yaw_deg : float
        Largest yaw that is searched, 0 … 75.
    max_faces : int
        At most this many, the most confident, ≥ 1.
    min_confidence : float
        0 … 1: least probability that it is a face, before a wall, a hand or a shoulder.

    Returns
    -------
    Faces
        Most confident first; empty with a reason if there is none.

    Raises
    ------
    ParameterError
        A parameter is out of range.
    """
    _check(radius_mm, min_gap_mm, max_yaw_deg, max_faces, min_confidence)
    if not image.mask.any():
        return Faces(reason=Reason.NO_VALID_PIXELS)
    reference = default_reference() if reference is None else reference
    found = [
        hypothesis
        for region in regions(image, min_gap_mm)
        for hypothesis in _search(image.masked(region), reference, max_yaw_deg)
        if hypothesis.score >= min_confidence
    ]
    if not found:
        return Faces(reason=Reason.NO_FACE)
    distinct = _distinct(sorted(found, key=lambda h: -h.score), _APART_MM)[:max_faces]
    return Faces([face_at(image, reference, h.pose, h.score, radius_mm) for h in distinct])


def regions(image: RangeImage, min_gap_mm: float) -> list[Mask]:
    """Connected regions (H, W bool) of the range slices, large enough for a face, nearest first."""
    depth = image.depth
    out: list[tuple[float, Mask]] = []
    for low, high in _valleys(depth[image.mask], min_gap_mm):
        layer = (depth >= low) & (depth < high)
        opened = cv2.morphologyEx(layer.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        count, labels = cv2.connectedComponents(opened, connectivity=4)
        for label in range(1, count):
            region = labels == label
            nearest = float(np.median(depth[region]))
            if region.sum() * image.camera.pixel_mm(nearest) ** 2 >= _MIN_AREA_MM2:
                out.append((nearest, region))
    return [region for _, region in sorted(out, key=lambda item: item[0])]


def _valleys(depths: Float32, min_gap_mm: float) -> list[tuple[float, float]]:
    """Intervals of depth between the valleys of its histogram."""
    bin_mm = min_gap_mm / 4.0
    low = float(depths.min())
    counts = np.bincount(((depths - low) / bin_mm).astype(np.int64))
    occupied = np.flatnonzero(counts > max(2, 1e-3 * len(depths)))
    if len(occupied) == 0:
        return [(low, float(depths.max()) + 1.0)]
    breaks = np.flatnonzero(np.diff(occupied) > 4)
    starts = occupied[np.r_[0, breaks + 1]]
    stops = occupied[np.r_[breaks, len(occupied) - 1]] + 1
    return [(low + bin_mm * a, low + bin_mm * b) for a, b in zip(starts, stops, strict=True)]


@lru_cache(maxsize=8)
def _grid(max_yaw_deg: float) -> Float64:
    return rotation_grid(
        np.linspace(-max_yaw_deg, max_yaw_deg, 2 * int(np.ceil(max_yaw_deg / 20.0)) + 1),
        _PITCHES_DEG,
        _ROLLS_DEG,
    )


def _search(image: RangeImage, reference: ReferenceFace, max_yaw_deg: float) -> list[_Hypothesis]:
    """Poses of faces in one region, best first: all candidates roughly, the best ones closely."""
    (points, weights, projection), pixel_mm = pooled(
        image, float(np.median(image.depth[image.mask]))
    )
    rotations = _grid(max_yaw_deg)
    tips, along = protruding(points, rotations, pixel_mm)
    if len(tips) == 0:
        return []
    rough, close = icp.Model(*reference.surface(80)), icp.Model(*reference.surface(400))

    tip, turn = np.nonzero(along)
    grid = np.full(along.shape, -1.0, np.float32)
    grid[tip, turn] = icp.scores(
        rough, rotations[turn], tips[tip], projection, points, tolerance_mm=12.0
    )
    tip, turn = _best_per_tip(grid, rotations)
    R, t = icp.align_many(
        rough, projection, points, weights, rotations[turn], tips[tip],
        gates_mm=_GATES[:6], scales_mm=_SCALES[:6],
    )  # fmt: skip
    order = np.argsort(-icp.scores(rough, R, t, projection, points, tolerance_mm=9.0))[:20]
    hypotheses = []
    for size in _SIZES:
        model = close.sized(size)
        refined = icp.align_many(
            model, projection, points, weights, R[order], t[order],
            gates_mm=_GATES[4:], scales_mm=_SCALES[4:],
        )  # fmt: skip
        hypotheses += [
            _Hypothesis(confidence(cues(model, R_k, t_k, projection, points)), R_k, t_k)
            for R_k, t_k in zip(*refined, strict=True)
            if _plausible(R_k, max_yaw_deg)
        ]
        if any(h.score >= _SURE for h in hypotheses):
            break
    return _distinct(sorted(hypotheses, key=lambda h: -h.score), 60.0)


def _plausible(rotation: Float64, max_yaw_deg: float) -> bool:
    """Whether ICP stayed near the poses that were searched; a head does not lie on its side."""
    yaw, pitch, roll = np.rad2deg(head_angles(rotation))
    return bool(
        abs(yaw) <= max_yaw_deg + _STRAY_DEG
        and abs(pitch) <= max(_PITCHES_DEG) + _STRAY_DEG
        and abs(roll) <= max(_ROLLS_DEG) + _STRAY_DEG
    )


def pooled(image: RangeImage, distance_mm: float) -> tuple[View, float]:
    """The image at the resolution of the search, and the width of its pixels, mm."""
    pixel_mm = image.camera.pixel_mm(distance_mm)
    factor = max(round(_SEARCH_PIXEL_MM / pixel_mm), 1)
    points = pool(image.depth, image.camera.projection, factor)
    weights = np.ones(points.shape[:2], np.float32)
    return View(points, weights, image.camera.projection.pooled(factor)), factor * pixel_mm


def protruding(points: Float32, rotations: Float64, pixel_mm: float) -> tuple[Float64, Mask]:
    """Points (n, 3) that protrude along some axis, one a cell of 10 mm; along which (n, r)."""
    pixels, along = protrusions(points, rotations, radius_px=max(round(25.0 / pixel_mm), 1))
    tips = points[pixels[:, 0], pixels[:, 1]].astype(np.float64)
    cells = np.floor(tips / 10.0).astype(np.int64)
    _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    merged = np.zeros((len(first), len(rotations)), bool)
    np.logical_or.at(merged, cell.ravel(), along)
    return tips[first], merged


def _best_per_tip(grid: Float32, rotations: Float64) -> tuple[Indices, Indices]:
    """Each tip with its best rotation, and with its best one at least 30° away."""
    best = grid.argmax(axis=1)
    # trace(RᵀQ) = 1 + 2 cos(angle)
    cosines = 0.5 * (np.einsum("aij,bij->ab", rotations, rotations) - 1.0)
    others = np.where(cosines[best] < np.cos(np.deg2rad(29.0)), grid, -1.0)
    second = others.argmax(axis=1)
    has_second = others.max(axis=1) > 0.0
    tips = np.arange(len(grid))
    return np.r_[tips, tips[has_second]], np.r_[best, second[has_second]]


def _distinct(hypotheses: list[_Hypothesis], radius_mm: float) -> list[_Hypothesis]:
    """Drop every hypothesis whose nose tip is near a better one's; best first."""
    kept: list[_Hypothesis] = []
    for h in hypotheses:
        if all(np.linalg.norm(h.translation - k.translation) > radius_mm for k in kept):
            kept.append(h)
    return kept


def _check(
    radius_mm: float, min_gap_mm: float, max_yaw_deg: float, max_faces: int, min_confidence: float
) -> None:
    if not radius_mm > 0:
        raise ParameterError(f"radius_mm must be > 0, got {radius_mm}")
    if not min_gap_mm > 0:
        raise ParameterError(f"min_gap_mm must be > 0, got {min_gap_mm}")
    if not 0 <= max_yaw_deg <= 75:
        raise ParameterError(f"max_yaw_deg must lie in 0 … 75, got {max_yaw_deg}")
    if max_faces < 1:
        raise ParameterError(f"max_faces must be ≥ 1, got {max_faces}")
    if not 0 <= min_confidence <= 1:
        raise ParameterError(f"min_confidence must lie in 0 … 1, got {min_confidence}")
