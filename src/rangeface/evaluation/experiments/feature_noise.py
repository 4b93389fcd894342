"""Which feature still tells people apart when the depth is noisy?

Faces are drawn without a camera: parallel rays onto the frontal grid, at several pixel sizes.
Everyone is enrolled from one clean neutral face. A probe is the same person on another occasion
(another session and a slight expression), with white noise of σ on its depth. A feature's worth is
how far apart its distances within a person and between persons lie:

    d′ = (mean between − mean within) / √((variance between + variance within) / 2)

Noise is independent between pixels, the pose is perfect, nothing is denoised: this asks what the
feature itself bears. Histograms are compared by χ², profiles by Pearson's coefficient, everything
else by Euclidean distance.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rangeface import describe
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Findings, Table
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.evaluation.pictures import canvas, png
from rangeface.numerics.similarity import similarity
from rangeface.pipeline import Step, step
from rangeface.simulate import head, render
from rangeface.types import Float32, Orthographic, PointSet, RangeImage

SIGMAS_MM = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
PITCHES_MM = (2.0, 2.8, 4.0)
CROP_MM = 140.0  # the paper's sphere around the nose tip

PROBES = 2  # of each person

Distances: TypeAlias = NDArray[np.float64]


class Arm(NamedTuple):
    """A feature under test: the method, how it is compared, and whose design it is."""

    feature: Step
    metric: str = "euclidean"
    origin: str = "redesigned"


ARMS: dict[str, Arm] = {
    "depth": Arm(step(describe.depth), origin="paper"),
    "N3, differences": Arm(step(describe.n3, method="difference"), origin="paper"),
    "arg π(N), differences": Arm(
        step(describe.normal_angle, unwrapped=False, method="difference"), origin="paper"
    ),
    "Gaussian curvature, differences": Arm(
        step(describe.curvature, kind="gaussian", method="difference"), origin="paper"
    ),
    "LBP8,1 riu2": Arm(step(describe.lbp, sigma_px=0), origin="paper"),
    "LBP8,1 u2": Arm(step(describe.lbp, method="u2", sigma_px=0), origin="paper"),
    "LBP16,2 riu2": Arm(step(describe.lbp, points=16, radius_px=2, sigma_px=0), origin="paper"),
    "3DLBP layer 1": Arm(step(describe.tdlbp, layers=(1,), sigma_px=0), origin="paper"),
    "3DLBP layer 3": Arm(step(describe.tdlbp, layers=(3,), sigma_px=0), origin="paper"),
    "HSO": Arm(step(describe.hso), origin="paper"),
    "LHG": Arm(step(describe.lhg), origin="paper"),
    "profiles": Arm(step(describe.profiles), "pearson", "paper"),
    "N3, plane": Arm(step(describe.n3)),
    "full N, differences": Arm(step(describe.normals, method="difference")),
    "full N, plane": Arm(step(describe.normals)),
    "full N, plane 3 px": Arm(step(describe.normals, radius_px=3)),
    "full N, quadric 4 px": Arm(step(describe.normals, method="quadric", radius_px=4)),
    "stereographic": Arm(step(describe.normals, components="stereographic")),
    "Lambert": Arm(step(describe.normals, components="lambert")),
    "log map": Arm(step(describe.normals, components="log")),
    "arg π(N), unwrapped": Arm(step(describe.normal_angle)),
    "mean curvature, fit": Arm(step(describe.curvature)),
    "shape index, fit": Arm(step(describe.curvature, kind="shape_index")),
    "LBP8,1 riu2, σ 1 px": Arm(step(describe.lbp)),
    "LBP8,1 riu2, σ 2 px": Arm(step(describe.lbp, sigma_px=2)),
    "LBP histograms": Arm(step(describe.lbp_histogram), "chi-square"),
    "3DLBP layer 1, σ 1 px": Arm(step(describe.tdlbp, layers=(1,))),
    "3DLBP layer 1, σ 2 px": Arm(step(describe.tdlbp, layers=(1,), sigma_px=2)),
    "3DLBP histograms": Arm(step(describe.tdlbp_histogram), "chi-square"),
    "local normal patterns": Arm(step(describe.local_normal_patterns)),
    "radial curves": Arm(step(describe.radial_curves)),
    "Gabor": Arm(step(describe.gabor)),
    "HOG": Arm(step(describe.hog)),
    "DT-CWT magnitudes": Arm(step(describe.dtcwt)),
    "block covariance": Arm(step(describe.block_covariance)),
}


TITLE = "Which feature still tells people apart when the depth is noisy?"


# ── cells ────────────────────────────────────────────────────────────────────────────────


@kept
def separation(
    store: Store, *, source: Source, pitch_mm: float, feature: Step, metric: str,
    sigmas_mm: tuple[float, ...] = SIGMAS_MM,
) -> Arrays:  # fmt: skip
    """The d′ of one feature at one pixel size: "d_prime", "low", "high", one number a σ."""
    faces = _faces(source, pitch_mm)
    gallery = np.stack([feature(person[0]).ravel() for person in faces])
    owner = np.repeat(np.arange(len(faces)), PROBES)
    # the same noise for every feature
    rng = np.random.default_rng([source.seed, int(10 * pitch_mm)])
    rows = []
    for sigma_mm in sigmas_mm:
        noisy = [
            f.with_depth(f.depth + rng.normal(0.0, sigma_mm, f.shape))
            for person in faces
            for f in person[1:]
        ]
        D = _distances(np.stack([feature(f).ravel() for f in noisy]), gallery, metric)
        rows.append((d_prime(D, owner), *interval(D, owner, np.random.default_rng(source.seed))))
    return dict(zip(("d_prime", "low", "high"), np.array(rows).T, strict=True))


@lru_cache(maxsize=2)
def _faces(source: Source, pitch_mm: float) -> list[list[RangeImage]]:
    heads = (
        _ict_heads(Path(source.folder), source.persons, np.random.default_rng(source.seed))
        if source.kind == "ict"
        else _own_heads(source)
    )
    return [[frontal(surface, pitch_mm) for surface in person] for person in heads]


def cells(source: Source) -> list[Cell]:
    """A cell a pixel size and feature."""
    source.need_heads("feature_noise")
    return [cell_of(source, pitch, arm) for pitch in PITCHES_MM for arm in ARMS.values()]


def cell_of(source: Source, pitch_mm: float, arm: Arm) -> Cell:
    """The cell of a feature at a pixel size."""
    return cell(
        separation, source=source, pitch_mm=pitch_mm, feature=arm.feature, metric=arm.metric
    )


# ── what comes of it ─────────────────────────────────────────────────────────────────────


def tabulate(source: Source, results: Results) -> Findings:
    """A table a pixel size, best at σ = 2 mm first, and a picture."""
    found = {
        (pitch, name): results(cell_of(source, pitch, arm))
        for pitch in PITCHES_MM
        for name, arm in ARMS.items()
    }
    return Findings(
        TITLE, "What does each feature bear, and at which pixel size?",
        readings=[
            "White noise, independent between pixels; perfect pose; nothing is denoised.",
            "d′: how far apart distances within and between people lie; intervals by drawing "
            "people, 95 %.",
        ],
        tables=[_table(found, pitch) for pitch in PITCHES_MM],
        figures=[_figure(found, source)],
    )  # fmt: skip


Found: TypeAlias = Mapping[tuple[float, str], Arrays]


def ranked(found: Found, pitch_mm: float, sigma_mm: float = 2.0) -> list[str]:
    """Features by their d′ at one noise and pixel size, best first."""
    place = SIGMAS_MM.index(sigma_mm)
    return sorted(ARMS, key=lambda name: -float(found[pitch_mm, name]["d_prime"][place]))


def _table(found: Found, pitch_mm: float) -> Table:
    rows = []
    for name in ranked(found, pitch_mm):
        result = found[pitch_mm, name]
        shown = zip(result["d_prime"], result["low"], result["high"], strict=True)
        rows.append(
            [
                name,
                ARMS[name].origin,
                *(f"{d:.2f} [{low:.2f}, {high:.2f}]" for d, low, high in shown),
            ]
        )
    header = ["feature", "design", *(f"σ {sigma:g} mm" for sigma in SIGMAS_MM)]
    caption = f"d′ with pixels of {pitch_mm:g} mm [95 %], best at σ = 2 mm first"
    return Table(f"pitch-{pitch_mm:g}", caption, header, rows)


def _figure(found: Found, source: Source) -> tuple[str, bytes]:
    """d′ against σ at 2.8 mm pixels: the best features, and the paper's."""
    from matplotlib import colormaps

    best = ranked(found, 2.8)
    figure = canvas((8.5, 5.0))
    axes = figure.subplots()
    axes.set_prop_cycle(color=colormaps["tab20"](range(20)))
    for name in best[:6] + [name for name in best[6:] if ARMS[name].origin == "paper"][:8]:
        style = "--" if ARMS[name].origin == "paper" else "-"
        axes.plot(SIGMAS_MM, found[2.8, name]["d_prime"], style, marker="o", label=name)
    axes.set(xscale="log", xlabel="σ of the depth, mm", ylabel="d′", title=str(source))
    axes.minorticks_off()
    axes.set_xticks(SIGMAS_MM, [f"{s:g}" for s in SIGMAS_MM])
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right upper", fontsize=8)
    return "d′ against noise, pixels of 2.8 mm; dashed: the paper's designs", png(figure)


# ── distances ────────────────────────────────────────────────────────────────────────────


def _distances(probe: Float32, gallery: Float32, metric: str) -> Distances:
    if metric == "pearson":
        centred = [x - x.mean(axis=1, keepdims=True) for x in (probe, gallery)]
        return 1.0 - np.asarray(similarity(*centred, metric="cosine"), np.float64)
    return -np.asarray(similarity(probe, gallery, metric=metric), np.float64)


def d_prime(D: Distances, owner: NDArray[np.intp]) -> float:
    """Separation of the distances (probes, people) within and between people."""
    same = owner[:, None] == np.arange(D.shape[1])
    within, between = D[same], D[~same]
    spread = np.sqrt(0.5 * (within.var() + between.var()))
    return float((between.mean() - within.mean()) / spread) if spread > 0 else 0.0


def interval(
    D: Distances, owner: NDArray[np.intp], rng: np.random.Generator, *, draws: int = 200
) -> tuple[float, float]:
    """95 % interval of d′ by drawing people with replacement; a double is not its own impostor.

    A guide, not a test: people drawn twice make the spread a little too small, d′ too large.
    """
    people, per_person = D.shape[1], len(owner) // D.shape[1]
    table = D.reshape(people, per_person, people)
    found = []
    for _ in range(draws):
        drawn = rng.choice(np.arange(people), people)
        sample = table[drawn][:, :, drawn]
        same = np.broadcast_to((drawn[:, None] == drawn)[:, None], sample.shape)
        if same.all():
            continue  # one person only: nobody to be told from
        within, between = sample[same], sample[~same]
        spread = np.sqrt(0.5 * (within.var() + between.var()))
        found.append((between.mean() - within.mean()) / max(spread, 1e-12))
    low, high = np.percentile(found, [2.5, 97.5])
    return float(low), float(high)


# ── faces ────────────────────────────────────────────────────────────────────────────────


def frontal(surface: PointSet, pitch_mm: float) -> RangeImage:
    """Frontal image, 140 × 224 mm inside the sphere, of a head in the face frame."""
    width, height = round(140.0 / pitch_mm), round(224.0 / pitch_mm)
    camera = Orthographic(pitch_mm, (width - 1) / 2, (height - 1) / 2, width, height)
    image = render(surface, camera).image
    return image.masked(np.linalg.norm(image.points, axis=-1) <= CROP_MM)


def _own_heads(source: Source) -> list[list[PointSet]]:
    """Per person: enrolled neutral, then slight expressions on other days."""
    return [
        [head(person).surface]
        + [
            head(person, expression="random", strength=0.3, session=day).surface
            for day in range(1, PROBES + 1)
        ]
        for person in source.numbers
    ]


def _ict_heads(path: Path, people: int, rng: np.random.Generator) -> list[list[PointSet]]:
    """People of the morphable model; a probe mixes five of its expressions at up to 0.3."""
    with np.load(path) as model:
        mean, triangles = model["mean"], model["tri"]
        nose = int(np.asarray(model["lm68"])[30])
        identities = model["ident"].astype(np.float32) * 0.01
        expressions = model["expr"].astype(np.float32) * 0.01
    heads = []
    for _ in range(people):
        weights = np.clip(rng.normal(size=len(identities)), -2.8, 2.8).astype(np.float32)
        neutral = mean + np.tensordot(weights, identities, 1)
        person = [_face_frame(neutral, nose, triangles)]
        for _ in range(PROBES):
            chosen = rng.choice(len(expressions), 5, replace=False)
            strength = rng.uniform(0.0, 0.3, 5).astype(np.float32)
            moved = neutral + np.tensordot(strength, expressions[chosen], 1)
            person.append(_face_frame(moved, nose, triangles))
        heads.append(person)
    return heads


def _face_frame(points: Float32, nose: int, triangles: NDArray[Any]) -> PointSet:
    """From x left of the subject, y up, z forward to the face frame: y down, z into the head."""
    return PointSet((points - points[nose]) * np.array([1.0, -1.0, -1.0], np.float32), triangles)


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=40, minutes=6.0)
