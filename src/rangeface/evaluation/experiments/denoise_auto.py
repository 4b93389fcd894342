"""Does `denoise.auto` ever cost recognition? As `denoise_by_recognition`, with many people.

Only `auto` and no denoising are compared: differences of a point or two need hundreds of probes.
"""

from __future__ import annotations

from itertools import product

from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.denoise_by_recognition import (
    CLASSIFIERS,
    FEATURES,
    LEVELS,
    READINGS,
    TRAININGS,
    Found,
    auto_table,
    cell_of,
)
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Entry, Findings, Table
from rangeface.evaluation.grid import Cell

COMPARED = ("none", "auto")
TITLE = "Does `denoise.auto` ever cost recognition?"


def cells(source: Source) -> list[Cell]:
    """A cell a level, with and without."""
    source.need_heads("denoise_auto")
    return [cell_of(source, level, denoiser) for denoiser, level in product(COMPARED, LEVELS)]


def tabulate(source: Source, results: Results) -> Findings:
    """The difference everywhere, and what the strongest noise leaves of the rate without noise."""
    found = {
        (level, denoiser): results(cell_of(source, level, denoiser))
        for level, denoiser in product(LEVELS, COMPARED)
    }
    return Findings(
        TITLE, "Is there a noise and a feature at which it is better not to denoise?",
        readings=list(READINGS), tables=[auto_table(found), _kept(found)],
    )  # fmt: skip


def _kept(found: Found) -> Table:
    """Rates at 34 dB beside those without noise, MLDA."""
    c = list(CLASSIFIERS).index("MLDA")

    def right(level: str, denoiser: str, f: int, t: int) -> Rate:
        hits = found[level, denoiser]["hits"][f, c, t]
        return Rate.of(int(hits.sum()), len(hits))

    rows: list[list[object]] = []
    for site, (t, training) in product(("crop", "scan"), enumerate(TRAININGS)):
        for f, feature in enumerate(FEATURES):
            clean = right(f"{site} clean", "none", f, 0)
            noisy, denoised = (right(f"{site} 34 dB", name, f, t) for name in COMPARED)
            share = f"{100.0 * denoised.rate / max(clean.rate, 1e-9):.0f}"
            rows.append(
                [site, feature, training, Entry(clean), Entry(noisy), Entry(denoised), share]
            )
    gain = float(found["crop 34 dB", "auto"]["gain_db"])
    caption = (
        "What 34 dB leaves, MLDA: rank 1, % [95 %], and the share of the noise-free rate kept by "
        f"`auto`, %. PSNR gain of `auto` at 34 dB on the crop: {gain:.1f} dB"
    )
    header = ["noise on the", "feature", "training", "noise-free", "34 dB", "34 dB, auto", "kept"]
    return Table("kept", caption, header, rows)


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=250, minutes=13.0)
