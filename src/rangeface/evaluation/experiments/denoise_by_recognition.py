"""Does a denoiser help or harm recognition, and at which noise?

Every person has two training scans (neutral, smiling) and two probes (neutral on another day,
laughing). A cell is one population × noise × denoiser; it holds, for every feature, classifier
and kind of training, which probes were recognised. Cells are kept as files, so that a run can be
cut short and taken up again.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rangeface import classify, denoise, describe
from rangeface.evaluation.experiments.noisy_captures import (
    QUIET_MM,
    ROLES,
    TRAINING,
    Noise,
    Surfaces,
    captures,
    ict_heads,
    noisy,
    observed,
    own_heads,
)
from rangeface.numerics.statistics import bootstrap_over_groups, wilson
from rangeface.pipeline import Step, step
from rangeface.types import Float32, Float64, RangeImage

REVISION = 1

# one grey level of the paper's images: 14 cm on 255 levels
_GREY_MM = 140.0 / 255.0
_PAPER = {"48 dB": 1, "42 dB": 2, "38 dB": 3, "34 dB": 5}

LEVELS = {
    "crop clean": Noise("crop", QUIET_MM),
    "scan clean": Noise("scan", QUIET_MM),
    **{f"crop {name}": Noise("crop", n * _GREY_MM) for name, n in _PAPER.items()},
    **{f"scan {name}": Noise("scan", n * _GREY_MM) for name, n in _PAPER.items()},
    **{f"tof {mm} mm": Noise("tof", float(mm)) for mm in (1, 2, 4, 8)},
}

DENOISERS: dict[str, Step] = {
    "none": step(denoise.none),
    "auto": step(denoise.auto),
    "dtcwt 2σ": step(denoise.dtcwt, shrinkage="soft"),
    "dtcwt bayes": step(denoise.dtcwt, shrinkage="bayes"),
    "dtcwt T = 20 mm": step(denoise.dtcwt, threshold_mm=20.0),
    "dwt 2σ": step(denoise.dwt),
    "dwt bivariate": step(denoise.dwt, shrinkage="bivariate"),
    "normalized convolution": step(denoise.normalized_convolution),
    "moving least squares": step(denoise.moving_least_squares),
    "median": step(denoise.median),
    "bilateral": step(denoise.bilateral),
    "guided": step(denoise.guided),
    "non-local means": step(denoise.non_local_means),
    "total variation": step(denoise.total_variation),
    "anisotropic diffusion": step(denoise.anisotropic_diffusion),
    "flying pixels": step(denoise.flying_pixels),
}

# on the crop as the paper computes them: nothing smooths after the noise
_BARE = {
    "depth": step(describe.depth),
    "N3": step(describe.n3, method="difference"),
    "full N": step(describe.normals, method="difference"),
    "3DLBP 1": step(describe.tdlbp, layers=(1,), sigma_px=0.0),
    "LBP8,1 riu2": step(describe.lbp, sigma_px=0.0),
}
# behind a resampled scan with their defaults
_DEFAULT = {
    "depth": step(describe.depth),
    "N3": step(describe.n3),
    "full N": step(describe.normals),
    "3DLBP 1": step(describe.tdlbp, layers=(1,)),
    "LBP8,1 riu2": step(describe.lbp),
}
FEATURES = tuple(_DEFAULT)
CLASSIFIERS: dict[str, Callable[[], classify.Matcher]] = {
    "PCA": lambda: classify.PCA(180),
    "MLDA": lambda: classify.MLDA(180, alpha=6.0),
}

Done: TypeAlias = dict[tuple[str, str, str], Mapping[str, Any]]


# ── cells ────────────────────────────────────────────────────────────────────────────────


class Run(NamedTuple):
    """What all cells of a run share."""

    population: str
    surfaces: Surfaces
    people: range
    folder: Path


def path_of(run: Run, level: str, denoiser: str) -> Path:
    """Where a cell is kept: a name that changes with everything that it depends on."""
    method = DENOISERS[denoiser]
    people = [run.people.start, run.people.stop]
    revision = getattr(method.method, "revision", 1)
    what = [REVISION, people, level, LEVELS[level], repr(method), revision]
    key = hashlib.sha256(json.dumps(what).encode()).hexdigest()[:16]
    return run.folder / f"{run.population}-{key}.json"


def cell(run: Run, level: str, denoiser: str) -> dict[str, Any]:
    """One cell: computed, or read where it was kept.

    Returns
    -------
    dict
        "hits": feature → classifier → training ("clean", "matched") → one "0" or "1" a probe;
        "gain_db": PSNR gain over the noisy image (crop only).
    """
    path = path_of(run, level, denoiser)
    if path.exists():
        return json.loads(path.read_text())
    answer = _cell(run, LEVELS[level], DENOISERS[denoiser]) | {
        "population": run.population,
        "level": level,
        "denoiser": denoiser,
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    partial.write_text(json.dumps(answer))
    partial.replace(path)
    return answer


def _cell(run: Run, noise: Noise, method: Step) -> dict[str, Any]:
    images = _observed(run, noise, method)
    people = np.arange(len(run.people))
    train, probes = np.tile(people, len(TRAINING)), np.tile(people, len(ROLES) - len(TRAINING))
    hits: dict[str, dict[str, dict[str, str]]] = {}
    for feature, describer in (_BARE if noise.site == "crop" else _DEFAULT).items():
        rows = {role: _vectors(images[role], describer) for role in ROLES}
        P = np.concatenate([rows[role] for role in ROLES[len(TRAINING) :]])
        X = np.concatenate([rows[role] for role in TRAINING])
        for name in CLASSIFIERS:
            # clean training knows neither the noise nor the denoiser
            clean, G = _trained(run, noise.site, feature, name)
            matched = CLASSIFIERS[name]().fit(X, train)
            hits.setdefault(feature, {})[name] = {
                "clean": _hits(clean, G, train, P, probes),
                "matched": _hits(matched, matched.transform(X), train, P, probes),
            }
    noisy_crop = noise.site == "crop" and noise.sigma_mm > QUIET_MM
    return {"hits": hits, "gain_db": _gain_db(run, noise, method) if noisy_crop else None}


def _observed(run: Run, noise: Noise, method: Step) -> dict[str, list[RangeImage]]:
    # the same noise for every denoiser: results are paired
    return {
        role: [
            observed(c, noise, method, np.random.default_rng([2, person, number]))
            for person, c in zip(run.people, taken, strict=True)
        ]
        for number, (role, taken) in enumerate(captures(run.surfaces, run.people).items())
    }


def _vectors(images: list[RangeImage], describer: Step) -> Float32:
    return np.stack([np.ravel(describer(image)) for image in images])


@lru_cache(maxsize=40)
def _trained(run: Run, site: str, feature: str, classifier: str) -> tuple[Any, Float32]:
    describer = (_BARE if site == "crop" else _DEFAULT)[feature]
    taken = captures(run.surfaces, run.people)
    X = np.concatenate([_vectors([c.frontal for c in taken[role]], describer) for role in TRAINING])
    model = CLASSIFIERS[classifier]().fit(X, np.tile(np.arange(len(run.people)), len(TRAINING)))
    return model, model.transform(X)


def _hits(model: Any, G: Float32, names: Any, P: Float32, truth: Any) -> str:
    best = names[np.argmax(model.similarity(model.transform(P), G), axis=1)]
    return "".join("1" if hit else "0" for hit in best == truth)


def _gain_db(run: Run, noise: Noise, method: Step) -> float:
    before, after = [], []
    taken = captures(run.surfaces, run.people)["neutral"]
    for person, capture in zip(run.people, taken, strict=True):
        clean = capture.frontal
        image = noisy(clean, noise.sigma_mm, np.random.default_rng([2, person, 0]))
        before.append(np.nanmean((image.depth - clean.depth) ** 2))
        after.append(np.nanmean((method(image).depth - clean.depth) ** 2))
    return float(10.0 * np.log10(np.mean(before) / np.mean(after)))


# ── the question ─────────────────────────────────────────────────────────────────────────


def run(
    *,
    seed: int = 0,
    people: int = 200,
    minutes: float = 45.0,
    folder: str | Path = "denoise_by_recognition",
    ict_facekit: str | Path | None = None,
    denoisers: Sequence[str] = tuple(DENOISERS),
) -> dict[str, Any]:
    """Run what is missing, within the time, and sum up.

    Parameters
    ----------
    seed : int
        The people are numbers 1000 · seed and up: seeds share nobody.
    people : int
        How many, ≤ 1000; two probes each.
    minutes : float
        After this no new cell is begun.
    folder : path
        Where the cells are kept.
    ict_facekit : path, optional
        The npz of ICT-FaceKit; without it only our own population is used.
    denoisers : sequence of str
        Which of `DENOISERS`, in the order of the run.

    Returns
    -------
    dict
        "cells": rates with intervals; "auto_minus_none": paired differences in points, pooled
        over classifiers and trainings, per population, level and feature; "missing": how many
        cells are still to be computed.
    """
    populations: dict[str, Surfaces] = {"own": own_heads()}
    if ict_facekit is not None:
        populations = {"ict": ict_heads(Path(ict_facekit)), **populations}
    end = time.monotonic() + 60.0 * minutes
    numbers = range(1000 * seed, 1000 * seed + people)
    done: Done = {}
    wanted = [(p, level, d) for p in populations for d in denoisers for level in LEVELS]
    for name, level, denoiser in wanted:
        this = Run(name, populations[name], numbers, Path(folder))
        if time.monotonic() < end or path_of(this, level, denoiser).exists():
            done[name, level, denoiser] = cell(this, level, denoiser)
    return {
        "people": people,
        "seed": seed,
        "missing": len(wanted) - len(done),
        "cells": [_summary(*key, content) for key, content in done.items()],
        "auto_minus_none": list(differences(done)),
    }


def _summary(
    population: str, level: str, denoiser: str, content: Mapping[str, Any]
) -> dict[str, Any]:
    rates = [
        [
            feature,
            classifier,
            training,
            hits.count("1") / len(hits),
            *wilson(hits.count("1"), len(hits)),
        ]
        for feature, by_classifier in content["hits"].items()
        for classifier, by_training in by_classifier.items()
        for training, hits in by_training.items()
    ]
    return {
        "population": population,
        "level": level,
        "denoiser": denoiser,
        "gain_db": content["gain_db"],
        "rates": rates,
    }


def differences(done: Done, first: str = "auto", second: str = "none") -> Iterator[list[Any]]:
    """Rate of one denoiser minus that of another, in points, with its 95 % interval.

    Per population, level and feature; a person's mean over probes, classifiers and trainings is
    one observation, and people are resampled.
    """
    for (population, level, denoiser), content in done.items():
        if denoiser != first or (population, level, second) not in done:
            continue
        base = done[population, level, second]["hits"]
        for feature, hits in content["hits"].items():
            gain = 100.0 * (_by_person(hits) - _by_person(base[feature]))
            yield [population, level, feature, float(gain.mean()), *_interval(gain)]


def _interval(gain: Float64) -> tuple[float, float]:
    def mean(people: NDArray[np.intp]) -> float:
        return float(np.mean(gain[people]))

    low, high = bootstrap_over_groups(mean, np.arange(len(gain)), rng=np.random.default_rng(0))
    return low, high


def _by_person(hits: Mapping[str, Mapping[str, str]]) -> Float64:
    strings = [string for by_training in hits.values() for string in by_training.values()]
    right = np.array([[digit == "1" for digit in string] for string in strings], dtype=np.float64)
    # probes run through all people once per role
    return right.reshape(len(strings), len(ROLES) - len(TRAINING), -1).mean(axis=(0, 1))
