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

import argparse
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rangeface import describe
from rangeface.numerics.similarity import similarity
from rangeface.simulate import head, render
from rangeface.types import Float32, Orthographic, PointSet, RangeImage

SIGMAS_MM = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
PITCHES_MM = (2.0, 2.8, 4.0)
CROP_MM = 140.0  # the paper's sphere around the nose tip

Distances = NDArray[np.float64]
Feature = Callable[[RangeImage], Float32]


class Arm(NamedTuple):
    """A feature under test: the method, how it is compared, and whose design it is."""

    feature: Feature
    metric: str = "euclidean"
    origin: str = "redesigned"


ARMS: dict[str, Arm] = {
    "depth": Arm(describe.depth, origin="paper"),
    "N3, differences": Arm(lambda f: describe.n3(f, method="difference"), origin="paper"),
    "arg π(N), differences": Arm(
        lambda f: describe.normal_angle(f, unwrapped=False, method="difference"), origin="paper"
    ),
    "Gaussian curvature, differences": Arm(
        lambda f: describe.curvature(f, kind="gaussian", method="difference"), origin="paper"
    ),
    "LBP8,1 riu2": Arm(lambda f: describe.lbp(f, sigma_px=0), origin="paper"),
    "LBP8,1 u2": Arm(lambda f: describe.lbp(f, method="u2", sigma_px=0), origin="paper"),
    "LBP16,2 riu2": Arm(
        lambda f: describe.lbp(f, points=16, radius_px=2, sigma_px=0), origin="paper"
    ),
    "3DLBP layer 1": Arm(lambda f: describe.tdlbp(f, layers=(1,), sigma_px=0), origin="paper"),
    "3DLBP layer 3": Arm(lambda f: describe.tdlbp(f, layers=(3,), sigma_px=0), origin="paper"),
    "HSO": Arm(describe.hso, origin="paper"),
    "LHG": Arm(describe.lhg, origin="paper"),
    "profiles": Arm(describe.profiles, "pearson", "paper"),
    "N3, plane": Arm(describe.n3),
    "full N, differences": Arm(lambda f: describe.normals(f, method="difference")),
    "full N, plane": Arm(describe.normals),
    "full N, plane 3 px": Arm(lambda f: describe.normals(f, radius_px=3)),
    "full N, quadric 4 px": Arm(lambda f: describe.normals(f, method="quadric", radius_px=4)),
    "stereographic": Arm(lambda f: describe.normals(f, components="stereographic")),
    "Lambert": Arm(lambda f: describe.normals(f, components="lambert")),
    "log map": Arm(lambda f: describe.normals(f, components="log")),
    "arg π(N), unwrapped": Arm(describe.normal_angle),
    "mean curvature, fit": Arm(describe.curvature),
    "shape index, fit": Arm(lambda f: describe.curvature(f, kind="shape_index")),
    "LBP8,1 riu2, σ 1 px": Arm(describe.lbp),
    "LBP8,1 riu2, σ 2 px": Arm(lambda f: describe.lbp(f, sigma_px=2)),
    "LBP histograms": Arm(describe.lbp_histogram, "chi-square"),
    "3DLBP layer 1, σ 1 px": Arm(lambda f: describe.tdlbp(f, layers=(1,))),
    "3DLBP layer 1, σ 2 px": Arm(lambda f: describe.tdlbp(f, layers=(1,), sigma_px=2)),
    "3DLBP histograms": Arm(describe.tdlbp_histogram, "chi-square"),
    "local normal patterns": Arm(describe.local_normal_patterns),
    "radial curves": Arm(describe.radial_curves),
    "Gabor": Arm(describe.gabor),
    "HOG": Arm(describe.hog),
    "DT-CWT magnitudes": Arm(describe.dtcwt),
    "block covariance": Arm(describe.block_covariance),
}


def run(
    *,
    seed: int = 0,
    people: int = 40,
    probes: int = 2,
    pitches_mm: tuple[float, ...] = PITCHES_MM,
    ict: Path | None = None,
) -> dict[str, Any]:
    """Measure d′ of every feature against noise and pixel size.

    Parameters
    ----------
    seed : int
        Of the noise and of the morphable model's people.
    people : int
        Number of people in each population, ≥ 3.
    probes : int
        Probes of each person.
    pitches_mm : tuple of float
        Pixel sizes, mm; the ranking needs 2.8.
    ict : Path, optional
        The morphable model `ict_facekit_mm.npz`; without it only our own heads are used.

    Returns
    -------
    dict
        "cells": one entry a population, pitch, σ and feature, with d′ and its 95 % interval
        (bootstrap over people); "ranking": features at σ = 2 mm and 2.8 mm pixels, averaged over
        the populations, best first, with what is left of their d′ at 0.25 mm.
    """
    populations: dict[str, list[list[PointSet]]] = {"own": _own_heads(people, probes)}
    if ict is not None:
        populations["ICT"] = _ict_heads(ict, people, probes, np.random.default_rng(seed))
    cells = [
        cell
        for name, heads in populations.items()
        for pitch_mm in pitches_mm
        for cell in _cells(name, heads, pitch_mm, seed)
    ]
    return {"seed": seed, "people": people, "cells": cells, "ranking": ranking(cells)}


def ranking(cells: list[dict[str, Any]], *, sigma_mm: float = 2.0) -> list[dict[str, Any]]:
    """Features by their d′ at one noise and 2.8 mm pixels, averaged over the populations."""

    def mean(feature: str, sigma: float) -> float:
        found = [
            c["d_prime"]
            for c in cells
            if (c["feature"], c["sigma_mm"], c["pitch_mm"]) == (feature, sigma, 2.8)
        ]
        return float(np.mean(found))

    rows = [
        {
            "feature": name,
            "origin": arm.origin,
            "d_prime": round(mean(name, sigma_mm), 2),
            "kept": round(mean(name, sigma_mm) / mean(name, min(SIGMAS_MM)), 2),
        }
        for name, arm in ARMS.items()
    ]
    return sorted(rows, key=lambda row: -float(row["d_prime"]))


def draw(result: dict[str, Any], path: Path) -> Path:
    """Picture of d′ against σ at 2.8 mm pixels, one panel a population, the best in colour."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    names = sorted({c["population"] for c in result["cells"]})
    best = [row["feature"] for row in result["ranking"]]
    shown = best[:6] + [name for name in best[6:] if ARMS[name].origin == "paper"][:8]
    figure = Figure(figsize=(6.0 * len(names) + 2.5, 5.0), layout="constrained")
    for axes, name in zip(np.ravel(figure.subplots(1, len(names))), names, strict=True):
        axes.set_prop_cycle(color=colormaps["tab20"](range(20)))
        for feature in shown:
            line = [
                c
                for c in result["cells"]
                if (c["population"], c["feature"], c["pitch_mm"]) == (name, feature, 2.8)
            ]
            style = "--" if ARMS[feature].origin == "paper" else "-"
            d = [c["d_prime"] for c in line]
            axes.plot([c["sigma_mm"] for c in line], d, style, marker="o", label=feature)
        axes.set(xscale="log", xlabel="σ of the depth, mm", ylabel="d′", title=f"{name} heads")
        axes.minorticks_off()
        axes.set_xticks(SIGMAS_MM, [f"{s:g}" for s in SIGMAS_MM])
        axes.grid(alpha=0.3)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", fontsize=8)
    figure.savefig(path, dpi=110)
    return path


# ── one cell ─────────────────────────────────────────────────────────────────────────────


def _cells(
    population: str, heads: list[list[PointSet]], pitch_mm: float, seed: int
) -> Iterator[dict[str, Any]]:
    """All features and noises of one population at one pixel size."""
    faces = [[frontal(h, pitch_mm) for h in person] for person in heads]
    clean = [person[0] for person in faces]
    gallery = {
        name: np.stack([arm.feature(f).ravel() for f in clean]) for name, arm in ARMS.items()
    }
    rng = np.random.default_rng([seed, int(10 * pitch_mm)])
    for sigma_mm in SIGMAS_MM:
        noisy = [
            f.with_depth(f.depth + rng.normal(0.0, sigma_mm, f.shape))
            for person in faces
            for f in person[1:]
        ]
        owner = np.repeat(np.arange(len(faces)), len(faces[0]) - 1)
        for name, arm in ARMS.items():
            probe = np.stack([arm.feature(f).ravel() for f in noisy])
            D = _distances(probe, gallery[name], arm.metric)
            low, high = interval(D, owner, np.random.default_rng(seed))
            yield {
                "population": population,
                "pitch_mm": pitch_mm,
                "sigma_mm": sigma_mm,
                "feature": name,
                "d_prime": d_prime(D, owner),
                "low": low,
                "high": high,
            }


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


def _own_heads(people: int, probes: int) -> list[list[PointSet]]:
    """Per person: enrolled neutral, then slight expressions on other days."""
    return [
        [head(person).surface]
        + [
            head(person, expression="random", strength=0.3, session=s).surface
            for s in range(1, probes + 1)
        ]
        for person in range(people)
    ]


def _ict_heads(
    path: Path, people: int, probes: int, rng: np.random.Generator
) -> list[list[PointSet]]:
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
        for _ in range(probes):
            chosen = rng.choice(len(expressions), 5, replace=False)
            strength = rng.uniform(0.0, 0.3, 5).astype(np.float32)
            moved = neutral + np.tensordot(strength, expressions[chosen], 1)
            person.append(_face_frame(moved, nose, triangles))
        heads.append(person)
    return heads


def _face_frame(points: Float32, nose: int, triangles: NDArray[Any]) -> PointSet:
    """From x left of the subject, y up, z forward to the face frame: y down, z into the head."""
    return PointSet((points - points[nose]) * np.array([1.0, -1.0, -1.0], np.float32), triangles)


def main() -> None:
    """Run from the command line: writes feature_noise.json and feature_noise.png."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", type=int, default=40)
    parser.add_argument("--ict", type=Path, default=None)
    parser.add_argument("--out", type=Path, default=Path())
    arguments = parser.parse_args()
    result = run(people=arguments.people, ict=arguments.ict)
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "feature_noise.json").write_text(json.dumps(result, indent=1))
    draw(result, arguments.out / "feature_noise.png")
    for row in result["ranking"]:
        print(
            f"{row['feature']:32s} {row['origin']:10s} d′ {row['d_prime']:5.2f} {row['kept']:5.2f}"
        )


if __name__ == "__main__":
    main()
