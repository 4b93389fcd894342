"""Does a denoiser help or harm recognition, and at which noise?

Every person has two training scans (neutral, smiling) and two probes (neutral on another day,
laughing). A cell is one noise × denoiser; it holds, for every feature, classifier and kind of
training, which probes were recognised.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rangeface import classify, denoise, describe
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.noisy_captures import (
    QUIET_MM,
    ROLES,
    TRAINING,
    Noise,
    captures,
    noisy,
    observed,
)
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Entry, Findings, Table
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.evaluation.pictures import canvas, png
from rangeface.numerics.statistics import bootstrap_over_groups
from rangeface.pipeline import Step, step
from rangeface.types import Float32, Float64, RangeImage

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
CLASSIFIERS: dict[str, Step] = {
    "PCA": Step(classify.PCA, (("n_components", 180),)),
    "MLDA": Step(classify.MLDA, (("alpha", 6.0), ("n_components", 180))),
}
TRAININGS = ("clean", "matched")
PROBES = len(ROLES) - len(TRAINING)
TITLE = "Does a denoiser help or harm recognition?"


# ── cells ────────────────────────────────────────────────────────────────────────────────


@kept
def outcomes(
    store: Store,
    *,
    source: Source,
    site: str,
    sigma_mm: float,
    denoiser: Step,
    describers: tuple[Step, ...],
    classifiers: tuple[Step, ...],
) -> Arrays:
    """Which probes are recognised after noise and a denoiser.

    Returns
    -------
    dict
        "hits" (features, classifiers, 2, probes) bool: after clean and after matched training,
        probes running through all people once per role; "gain_db": PSNR gain of the denoiser on
        the crop, NaN elsewhere.
    """
    noise = Noise(site, sigma_mm)
    images = _observed(source, noise, denoiser)
    people = np.arange(source.persons)
    train, truth = np.tile(people, len(TRAINING)), np.tile(people, PROBES)
    hits = np.zeros((len(describers), len(classifiers), len(TRAININGS), len(truth)), bool)
    for f, describer in enumerate(describers):
        rows = {role: _vectors(images[role], describer) for role in ROLES}
        P = np.concatenate([rows[role] for role in ROLES[len(TRAINING) :]])
        X = np.concatenate([rows[role] for role in TRAINING])
        for c, classifier in enumerate(classifiers):
            matched = classifier().fit(X, train)
            models = (
                _clean(source, describer, classifier),
                (matched, matched.transform(X)),
            )
            for t, (model, G) in enumerate(models):
                alike = model.similarity(model.transform(P), G)
                hits[f, c, t] = train[np.argmax(alike, axis=1)] == truth
    on_crop = noise.site == "crop" and noise.sigma_mm > QUIET_MM
    gain = _gain_db(source, noise, denoiser) if on_crop else np.nan
    return {"hits": hits, "gain_db": np.array(gain)}


def _observed(source: Source, noise: Noise, denoiser: Step) -> dict[str, list[RangeImage]]:
    # the same noise for every denoiser: results are paired
    return {
        role: [
            observed(c, noise, denoiser, np.random.default_rng([2, person, number]))
            for person, c in zip(source.numbers, taken, strict=True)
        ]
        for number, (role, taken) in enumerate(captures(source).items())
    }


def _vectors(images: list[RangeImage], describer: Step) -> Float32:
    return np.stack([np.ravel(describer(image)) for image in images])


@lru_cache(maxsize=40)
def _clean(source: Source, describer: Step, classifier: Step) -> tuple[Any, Float32]:
    """Learnt from clean scans: it knows neither the noise nor the denoiser."""
    taken = captures(source)
    X = np.concatenate([_vectors([c.frontal for c in taken[role]], describer) for role in TRAINING])
    model = classifier().fit(X, np.tile(np.arange(source.persons), len(TRAINING)))
    return model, model.transform(X)


def _gain_db(source: Source, noise: Noise, denoiser: Step) -> float:
    before, after = [], []
    taken = captures(source)["neutral"]
    for person, capture in zip(source.numbers, taken, strict=True):
        clean = capture.frontal
        image = noisy(clean, noise.sigma_mm, np.random.default_rng([2, person, 0]))
        before.append(np.nanmean((image.depth - clean.depth) ** 2))
        after.append(np.nanmean((denoiser(image).depth - clean.depth) ** 2))
    return float(10.0 * np.log10(np.mean(before) / np.mean(after)))


def cells(source: Source) -> list[Cell]:
    """A cell a level and denoiser."""
    source.need_heads("denoise_by_recognition")
    return [cell_of(source, level, denoiser) for denoiser, level in product(DENOISERS, LEVELS)]


def cell_of(source: Source, level: str, denoiser: str) -> Cell:
    """The cell of a level and a denoiser."""
    noise = LEVELS[level]
    describers = _BARE if noise.site == "crop" else _DEFAULT
    return cell(
        outcomes, source=source, **noise._asdict(), denoiser=DENOISERS[denoiser],
        describers=tuple(describers.values()), classifiers=tuple(CLASSIFIERS.values()),
    )  # fmt: skip


# ── what comes of it ─────────────────────────────────────────────────────────────────────


def tabulate(source: Source, results: Results) -> Findings:
    """Rates after clean and matched training, what auto gains or costs, and a picture."""
    found = {
        (level, denoiser): results(cell_of(source, level, denoiser))
        for level, denoiser in product(LEVELS, DENOISERS)
    }
    return Findings(
        TITLE, "At which noise does which denoiser help, and does `auto` ever harm?",
        readings=list(READINGS),
        tables=[auto_table(found), *(_rates(found, training) for training in TRAININGS)],
        figures=[_figure(found)],
    )  # fmt: skip


Found = Mapping[tuple[str, str], Arrays]


def _rates(found: Found, training: str) -> Table:
    t = TRAININGS.index(training)
    rows: list[list[object]] = []
    for level, denoiser in product(LEVELS, DENOISERS):
        result = found[level, denoiser]
        gain = float(result["gain_db"])
        row: list[object] = [level, denoiser, "" if np.isnan(gain) else f"{gain:.1f}"]
        for f, c in np.ndindex(len(FEATURES), len(CLASSIFIERS)):
            right = result["hits"][f, c, t]
            row.append(Entry(Rate.of(int(right.sum()), len(right))))
        rows.append(row)
    header = ["noise", "denoiser", "gain, dB", *map(" ".join, product(FEATURES, CLASSIFIERS))]
    return Table(training, f"Rank 1 after {training} training, % [95 %]", header, rows)


def auto_table(found: Found) -> Table:
    """`denoise.auto` minus no denoising: a row a level, a column a feature."""
    rows = []
    for level in LEVELS:
        row = [level]
        for f in range(len(FEATURES)):
            mean, low, high = difference(found[level, "auto"], found[level, "none"], f)
            row.append(f"{mean:+.1f} [{low:+.1f}, {high:+.1f}]")
        rows.append(row)
    caption = (
        "`denoise.auto` minus no denoising, points [95 % by bootstrap over people], pooled over "
        "classifiers and trainings"
    )
    return Table("auto", caption, ["noise", *FEATURES], rows)


def difference(first: Arrays, second: Arrays, feature: int) -> tuple[float, float, float]:
    """Rate of one cell minus another's for a feature, in points, with its 95 % interval.

    A person's mean over probes, classifiers and trainings is one observation; people are
    resampled.
    """
    one, other = (
        # probes run through all people once per role
        result["hits"][feature].reshape(-1, result["hits"].shape[-1] // PROBES).mean(axis=0)
        for result in (first, second)
    )
    gain: Float64 = 100.0 * (one - other)

    def mean(people: NDArray[np.intp]) -> float:
        return float(np.mean(gain[people]))

    low, high = bootstrap_over_groups(mean, np.arange(len(gain)), rng=np.random.default_rng(0))
    return float(gain.mean()), low, high


def _figure(found: Found) -> tuple[str, bytes]:
    """Rate against noise, no denoising beside `auto`: a row a site, a column a feature (MLDA)."""
    sites = ("crop", "scan", "tof")
    c = list(CLASSIFIERS).index("MLDA")
    figure = canvas((12.0, 6.6))
    axes = figure.subplots(len(sites), len(FEATURES), sharey=True, squeeze=False)
    for (row, site), (f, feature) in product(zip(axes, sites, strict=True), enumerate(FEATURES)):
        levels = [name for name in LEVELS if name.startswith(site)]
        for (denoiser, colour), (t, training) in product(
            (("none", "tab:red"), ("auto", "tab:blue")), enumerate(TRAININGS)
        ):
            line = [100.0 * found[level, denoiser]["hits"][f, c, t].mean() for level in levels]
            row[f].plot(line, "-" if t == 0 else ":", color=colour, marker=".",
                        label=f"{denoiser}, {training} training")  # fmt: skip
        row[f].set_xticks(range(len(levels)), [name.removeprefix(f"{site} ") for name in levels])
        row[f].tick_params(labelsize=7)
        row[f].set(ylim=(0, 103))
        row[f].set_title(f"{site}: {feature}", fontsize=9)
    axes[0, 0].legend(fontsize=6, loc="lower left")
    return "Rank 1 (%) against noise, MLDA: no denoising and `denoise.auto`", png(figure)


READINGS = (
    "Pose varies by 4° (σ) and the registration errs by 0.8° and 0.7 mm (σ); 176 × 144 pixels of "
    "2 mm at 40 cm, then 80 × 50 of 2.8 mm.",
    "crop: the paper's noise on the crop, features without smoothing. scan: the same σ on the "
    "range image, features with their defaults. tof: σ ∝ 1/amplitude, the figure is the median.",
    "Training scans are neutral and smiling, probes neutral and laughing; the probes of our own "
    "population are taken on another day.",
    "clean training knows neither noise nor denoiser, matched training has both.",
)

EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=60, minutes=12.0)
