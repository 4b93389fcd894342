"""Does the model that ships recognise people whom it has never met, and refuse strangers?

People before the SR-3000: one enrolment of ten frames a person; on another day a neutral frame,
twenty neutral frames, a smile and a laugh. Open set: five times as many strangers, twenty frames
each. Nothing is learned from them. With ICT-FaceKit (a user's own copy) it is a population of which
the model has never seen anybody.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from rangeface.evaluation.comparisons import Comparisons
from rangeface.evaluation.error_rates import (
    Rate,
    failure_to_acquire,
    fmr,
    fnmr,
    mated_nonmated,
    rank_k,
)
from rangeface.evaluation.experiments import models
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.experiments.visits import ENROLMENT, Visit, made, templates_of
from rangeface.evaluation.findings import Claim, Findings, Table, Verdict, judge
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.evaluation.open_set import best_scores, fnir_at_fpir, fpir
from rangeface.gallery import stack
from rangeface.numerics.statistics import rule_of_three
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Float64

SEQUENCE = "neutral, 20 frames"
PROBES = {
    "neutral, one frame": Visit("neutral", 1, 1),
    SEQUENCE: Visit("neutral", 1, 20),
    "smile, 20 frames": Visit("smile", 1, 20),
    "laugh, 20 frames": Visit("laugh", 1, 20),
}
#: For each person enrolled.
STRANGERS = 5
FMR, FMRS, FPIR = 1e-3, (1e-3, 1e-4), 0.01
TITLE = "The model that ships, on people whom it has never met"

Scores: TypeAlias = Mapping[str, Float64]


# ── cells ────────────────────────────────────────────────────────────────────────────────


@kept
def scores(
    store: Store, *, model: str, enrolled: tuple[Cell, ...], probes: tuple[Cell, ...]
) -> Arrays:
    """Everybody who comes against everybody who is enrolled.

    Returns
    -------
    dict
        "scores" (probes, enrolled) float32, NaN where one of the two failed to acquire.
    """
    asked = models.recognizer(model)
    fingerprint = asked.pipeline.fingerprint
    people = made(store, enrolled, fingerprint)
    known = [(str(k), template) for k, template in enumerate(people) if template is not None]
    references = stack(known, fingerprint)
    place = [int(subject) for subject in references.subjects]
    came = made(store, probes, fingerprint)
    table = np.full((len(came), len(people)), np.nan, np.float32)
    for row, template in zip(table, came, strict=True):
        if template is not None and known:
            row[place] = asked.scores(template, references)
    return {"scores": table}


def cells(source: Source) -> list[Cell]:
    """A cell a visit, and one of the strangers."""
    source.need_heads("shipped_model")
    return [*(known(source, visit) for visit in PROBES.values()), strangers(source)]


def known(source: Source, visit: Visit) -> Cell:
    """The scores of the people enrolled, on a visit."""
    return _scores(source, visit, _enrolled(source))


def strangers(source: Source) -> Cell:
    """The scores of people who are not enrolled."""
    last = _enrolled(source).stop
    return _scores(source, PROBES[SEQUENCE], range(last, last + STRANGERS * source.persons))


def _scores(source: Source, visit: Visit, people: range) -> Cell:
    return cell(
        scores, model=models.shipped(), enrolled=templates_of(source, ENROLMENT, _enrolled(source)),
        probes=templates_of(source, visit, people),
    )  # fmt: skip


def _enrolled(source: Source) -> range:
    first = models.newcomers(source)
    return range(first, first + source.persons)


# ── what comes of it ─────────────────────────────────────────────────────────────────────


def tabulate(source: Source, results: Results) -> Findings:
    """Rates of every kind of probe, at the calibrated threshold and in an open set."""
    asked = models.recognizer(models.shipped())
    people = [f"person {k}" for k in range(source.persons)]
    tables = {
        name: results(known(source, visit))["scores"].astype(np.float64)
        for name, visit in PROBES.items()
    }
    unknown = results(strangers(source))["scores"].astype(np.float64)
    return Findings(
        TITLE, "What may be expected of people from whom nothing was learned?",
        readings=[
            *READINGS,
            f"{source.persons} people enrolled, {len(unknown)} strangers. Failures to enrol: "
            f"{_failures_to_enrol(tables)}. Failures to acquire count as errors.",
        ],
        tables=[
            _rates(tables, people, asked.threshold(FMR)),
            _open_set(tables, people, unknown),
            _let_in(unknown, asked),
        ],
        verdicts=_verdicts(tables, asked.threshold(FMR)),
        comparisons=(f"{SEQUENCE}, and strangers", _comparisons(tables[SEQUENCE], unknown, people)),
    )  # fmt: skip


def _failures_to_enrol(tables: Scores) -> Rate:
    # nobody was ever compared with them
    failed = np.isnan(np.concatenate(list(tables.values()))).all(axis=0)
    return Rate.of(int(failed.sum()), len(failed))


def _rates(tables: Scores, people: list[str], threshold: float) -> Table:
    rows = []
    for name, table in tables.items():
        mated, nonmated = mated_nonmated(table, people, people)
        rates = (
            rank_k(table, people, people), failure_to_acquire(table),
            fnmr(mated, threshold), fmr(nonmated, threshold),
        )  # fmt: skip
        rows.append([name, *map(str, rates)])
    caption = (
        f"Rates [95 %] (counts); threshold where the model's calibration promises an FMR of "
        f"{100 * FMR:g} %"
    )
    header = ["probe", "rank 1", "not acquired", "FNMR at that threshold", "FMR at that threshold"]
    return Table("shipped_model", caption, header, rows)


def _open_set(tables: Scores, people: list[str], unknown: Float64) -> Table:
    best = best_scores(unknown)
    rate = max(FPIR, rule_of_three(int(np.count_nonzero(~np.isnan(best)))))
    rows = [
        [name, str(fnir_at_fpir(table, people, people, unknown, rate))]
        for name, table in tables.items()
    ]
    caption = (
        f"Open set: people enrolled who are not named where {100 * rate:.2g} % of the strangers "
        "are named [95 %]"
    )
    return Table("open_set", caption, ["probe", f"FNIR at FPIR {100 * rate:.2g} %"], rows)


def _let_in(unknown: Float64, asked: FaceRecognizer) -> Table:
    rows = [[f"{100 * f:g} %", str(fpir(unknown, asked.threshold(f)))] for f in FMRS]
    caption = "Strangers who are named at the calibration's thresholds [95 %]"
    return Table("strangers", caption, ["FMR of a comparison promised", "FPIR found"], rows)


def _verdicts(tables: Scores, threshold: float) -> list[Verdict]:
    accepted = {name: table.diagonal() >= threshold for name, table in tables.items()}
    one, sequence, smile, laugh = accepted
    orderings = (
        ("Twenty frames are accepted more often than one", sequence, one),
        ("A neutral face is accepted more often than a smile", sequence, smile),
        ("A neutral face is accepted more often than a laugh", sequence, laugh),
    )
    return judge(
        [
            Claim(text, "ours", accepted[better], accepted[worse], np.arange(len(accepted[worse])))
            for text, better, worse in orderings
        ]
    )


def _comparisons(table: Float64, unknown: Float64, people: list[str]) -> Comparisons:
    everybody = (*people, *(f"stranger {k}" for k in range(len(unknown))))
    return Comparisons(
        np.concatenate([table, unknown]), everybody, tuple(people), everybody, tuple(people)
    )


READINGS = (
    "Simulated SwissRanger SR-3000 at 40 cm; enrolled from ten frames. Probes are of another day, "
    "with a tenth of a random gesture and another pose (σ 3°).",
    "The model and its thresholds are as they ship; it was trained and calibrated on simulated "
    "people of our own population. With `--data ict:PATH` even the population is new to it.",
)

EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=200, minutes=9.0)
