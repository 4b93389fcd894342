"""Are our simulated people as different, and as hard to recognise, as a published model's people?

The same protocol runs on the own population and on ICT-FaceKit (a user's own copy): distances
between people, a map of where they differ, and rank-1 of three features with laughing probes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from rangeface import describe, simulate
from rangeface.classify import PCA
from rangeface.errors import ParameterError
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Entry, Findings, Table
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.evaluation.pictures import canvas, png, tile
from rangeface.numerics.se3 import best_fit
from rangeface.types import Float32, Float64, Mask, Orthographic, RangeImage, RigidTransform

Population: TypeAlias = Callable[..., simulate.Head]

# the source paper's 80 × 50 pixels on its crop of 100 × 160 mm
CAMERA = Orthographic(2.0, 24.5, 39.5, 50, 80)
CROP_MM = 100.0  # radius of the sphere around the nose tip that counts as the face
DEEPEST_MM = 85.0  # what lies further behind the nose tip is ear or neck
COMPONENTS = 180
FEATURES: dict[str, Callable[[RangeImage], Float32]] = {
    "depth": describe.depth,
    "3DLBP layer 1": lambda image: describe.tdlbp(image, layers=(1,)),
    "N3": describe.n3,
}


PAIRS = 60  # of people whose distance is measured
NOSE_ERRORS_MM = (3.0, 0.0)  # σ of the nose tip in x and in y, gallery and probes
TITLE = "Are our simulated people as different, and as hard to recognise, as a published model's?"
SIDES = ("own", "ict")


# ── cells ────────────────────────────────────────────────────────────────────────────────


@kept
def measured(
    store: Store,
    *,
    source: Source,
    side: str,
    pairs: int = PAIRS,
    nose_errors_mm: tuple[float, ...] = NOSE_ERRORS_MM,
) -> Arrays:
    """One population under the protocol.

    Returns
    -------
    dict
        "distances_mm" (by vertex, by closest point), "hits" (errors, features) of as many probes
        as people, "variance_mm2" (80, 50).
    """
    population, mean = _population(source, side)
    apart = distances(population, mean, pairs)
    hits = [
        [rate.count for rate in difficulty(population, source.persons, e, source.seed).values()]
        for e in nose_errors_mm
    ]
    return {
        "distances_mm": np.array([apart["by_vertex_mm"], apart["by_closest_point_mm"]]),
        "hits": np.array(hits),
        "variance_mm2": variance_map(population, source.persons),
    }


def _population(source: Source, side: str) -> tuple[Population, Float32]:
    if side == "own":
        return simulate.head, simulate.mean_head().surface.points
    model = simulate.ict_facekit(source.folder)
    return model.head, model.mean


def cells(source: Source) -> list[Cell]:
    """A cell a population."""
    if source.kind != "ict":
        raise ParameterError("data: population_against_ict needs ict:PATH, a copy of ICT-FaceKit")
    return [cell(measured, source=source, side=side) for side in SIDES]


def tabulate(source: Source, results: Results) -> Findings:
    """Distances, rank 1 and where people differ, side by side; and pictures to look at."""
    own, ict = (results(one) for one in cells(source))
    apart = [
        [name, f"{a:.2f}", f"{b:.2f}", f"{a / b:.2f}"]
        for name, a, b in zip(
            ("by vertex", "by closest point"), own["distances_mm"], ict["distances_mm"], strict=True
        )
    ]
    ranks: list[list[object]] = [
        [f"{error:g} mm", feature]
        + [Entry(Rate.of(int(side["hits"][e, f]), source.persons)) for side in (own, ict)]
        for e, error in enumerate(NOSE_ERRORS_MM)
        for f, feature in enumerate(FEATURES)
    ]
    where = [regions(side["variance_mm2"]) for side in (own, ict)]
    places = [[name, *(f"{side[name]:.1f}" for side in where)] for name in where[0]]
    return Findings(
        TITLE, "Do results on simulated people carry over to people of another model?",
        readings=[
            f"{source.persons} people enrolled neutral, laughing probes; nearest neighbour after "
            "PCA; the nose tip is wrong by the stated σ.",
        ],
        tables=[
            Table("distances", f"RMS distance of {PAIRS} pairs of people, mm",
                  ["distance", "own", "ICT-FaceKit", "ratio"], apart),
            Table("rank1", "Rank 1, % [95 %]", ["nose error", "feature", *SIDES], ranks),
            Table("regions", "Variance of the depth over parts of the face, mm²",
                  ["part", *SIDES], places),
        ],
        figures=[
            *(_contact_sheet(source, side) for side in SIDES),
            _variance_maps(own["variance_mm2"], ict["variance_mm2"]),
        ],
    )  # fmt: skip


# ── how far apart people are ─────────────────────────────────────────────────────────────


def distances(population: Population, mean: Float32, pairs: int) -> dict[str, float]:
    """Mean over pairs of the RMS distance after rigid alignment, over the face.

    By vertex: corresponding vertices. By closest point: vertices of one to a dense sample of the
    other's surface, after iterating closest points.
    """
    face = (np.linalg.norm(mean, axis=1) < CROP_MM) & (mean[:, 2] < DEEPEST_MM)
    near = np.linalg.norm(mean, axis=1) < 1.3 * CROP_MM
    by_vertex, by_point = [], []
    for pair in range(pairs):
        one, other = (population(2 * pair + k).surface for k in (0, 1))
        a, b = one.points.astype(np.float64), other.points.astype(np.float64)
        R, t = best_fit(a[face], b[face])
        moved = a[face] @ R.T + t
        by_vertex.append(_rms(np.linalg.norm(moved - b[face], axis=1)))
        by_point.append(_closest(moved, _dense(b, other.triangles, near)))
    return {
        "by_vertex_mm": float(np.mean(by_vertex)),
        "by_closest_point_mm": float(np.mean(by_point)),
    }


def _dense(points: Float64, triangles: NDArray[np.int32] | None, near: Mask) -> Float64:
    # vertices, middles of edges and of triangles: meshes of different fineness become comparable
    assert triangles is not None
    corners = points[triangles[near[triangles].all(axis=1)]]
    edges = 0.5 * (corners + np.roll(corners, 1, axis=1))
    return np.concatenate([points[near], edges.reshape(-1, 3), corners.mean(axis=1)])


def _closest(moved: Float64, other: Float64, rounds: int = 15) -> float:
    tree = cKDTree(other)
    for _ in range(rounds):
        _, nearest = tree.query(moved)
        R, t = best_fit(moved, other[nearest])
        moved = moved @ R.T + t
    return _rms(tree.query(moved)[0])


def _rms(values: Float64) -> float:
    return float(np.sqrt(np.mean(values**2)))


# ── how hard they are to tell apart ──────────────────────────────────────────────────────


def difficulty(
    population: Population, people: int, nose_error_mm: float, seed: int
) -> dict[str, Rate]:
    """Rank-1 of every feature at one size of the nose tip's error."""
    images = frontals(population, people, nose_error_mm, seed)
    return {name: rank1(images, feature) for name, feature in FEATURES.items()}


def frontals(
    population: Population, people: int, nose_error_mm: float, seed: int
) -> dict[str, list[RangeImage]]:
    """Gallery (neutral) and probes (laughing) with an error of the nose tip."""
    rng = np.random.default_rng(seed)
    errors = nose_error_mm * rng.standard_normal((2, people, 2))
    return {
        role: [_frontal(population(p, expression=expression), errors[k, p]) for p in range(people)]
        for k, (role, expression) in enumerate((("gallery", "neutral"), ("probe", "laugh")))
    }


def _frontal(head: simulate.Head, error_mm: Float64) -> RangeImage:
    # the wrong nose tip lies on the surface, so the error in depth follows from the other two
    shift = np.array([-error_mm[0], -error_mm[1], 0.0])
    away = RigidTransform(np.eye(3), shift, target="camera", source="face")
    depth = simulate.render(head, CAMERA, away).image.depth
    middle = depth[39:41, 24:26].mean()
    behind = depth - middle
    x, y, _ = np.moveaxis(CAMERA.back_project(behind), -1, 0)
    inside = x**2 + y**2 + behind**2 < CROP_MM**2
    return RangeImage(np.where(inside, behind, np.nan), CAMERA)


def rank1(images: dict[str, list[RangeImage]], feature: Callable[[RangeImage], Float32]) -> Rate:
    """Rank-1 of the nearest neighbour after PCA on the gallery, with its 95 % interval."""
    gallery, probes = (
        np.stack([feature(image).ravel() for image in images[role]])
        for role in ("gallery", "probe")
    )
    pca = PCA(n_components=COMPONENTS).fit(gallery)
    scores = pca.similarity(pca.transform(probes), pca.transform(gallery))
    return Rate.of(int((scores.argmax(axis=1) == np.arange(len(probes))).sum()), len(probes))


# ── where they differ ────────────────────────────────────────────────────────────────────


def variance_map(population: Population, people: int) -> Float64:
    """Variance of the depth behind the nose tip at every pixel, mm²; NaN outside the face."""
    depth = np.stack([_frontal(population(p), np.zeros(2)).depth for p in range(people)])
    known = np.isfinite(depth)
    count = known.sum(axis=0)
    mean = np.where(known, depth, 0.0).sum(axis=0) / np.maximum(count, 1)
    square = (np.where(known, depth - mean, 0.0) ** 2).sum(axis=0) / np.maximum(count - 1, 1)
    return np.where(count > 0.9 * people, square, np.nan)


def regions(variance: Float64) -> dict[str, float]:
    """Mean of the variance map over parts of the face, mm²."""
    return {name: float(np.nanmean(variance[mask])) for name, mask in _regions().items()}


def _regions() -> dict[str, Mask]:
    v, u = np.mgrid[:80, :50]
    x, y = np.abs((u - CAMERA.cx) * 2.0), (v - CAMERA.cy) * 2.0
    return {
        "forehead": (y < -50) & (y > -78) & (x < 40),
        "eyes": (y > -48) & (y < -28) & (x > 14) & (x < 46),
        "nose": (y > -40) & (y < 12) & (x < 14),
        "cheeks": (y > -24) & (y < 24) & (x > 20) & (x < 48),
        "mouth": (y > 14) & (y < 46) & (x < 26),
        "chin": (y > 48) & (y < 76) & (x < 20),
    }


# ── to look at ───────────────────────────────────────────────────────────────────────────


def _contact_sheet(source: Source, side: str, people: int = 24) -> tuple[str, bytes]:
    population, _ = _population(source, side)
    shown = [np.repeat(shaded(population(k))[..., None], 3, axis=-1) for k in range(people)]
    return f"The first {people} people: {side}", png(tile(shown, [""] * people, columns=8))


def _variance_maps(*maps: NDArray[np.float64]) -> tuple[str, bytes]:
    figure = canvas((7.0, 4.0))
    for axes, variance, side in zip(figure.subplots(1, 2), maps, SIDES, strict=True):
        shown = axes.imshow(np.sqrt(variance), vmin=0, vmax=12)
        axes.set_title(side)
        figure.colorbar(shown, ax=axes)
    return "Standard deviation of the depth between people, mm", png(figure)


def shaded(head: simulate.Head, *, yaw_deg: float = 20.0) -> NDArray[np.float64]:
    """A head under a lamp from above, turned a little: (260, 200) in 0 … 1, white around it."""
    camera = Orthographic(1.0, 99.5, 140.0, 200, 260)
    view = simulate.render(head, camera, simulate.pose(yaw_deg=yaw_deg), oversample=3)
    lamp = np.array([-0.35, -0.5, -0.8])
    light = np.clip(view.normal @ (lamp / np.linalg.norm(lamp)), 0.0, 1.0)
    fine = np.where(np.isfinite(view.depth), 0.1 + 0.9 * light, 1.0)
    return np.asarray(fine.reshape(260, 3, 200, 3).mean(axis=(1, 3)))


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=200, minutes=5.0)
