"""What does a denoiser do to real captures? The preset `full-n-mlda` with each method before it.

The database's first protocol decides what is learnt, enrolled and asked; a capture that is not
acquired counts as an error.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from rangeface.config import load_pipeline
from rangeface.datasets import DATABASES
from rangeface.errors import ParameterError
from rangeface.evaluation.captures import acquire, learners
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.denoise_by_recognition import DENOISERS
from rangeface.evaluation.experiments.sources import Source, database
from rangeface.evaluation.findings import Entry, Findings, Table
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.evaluation.protocol import compare
from rangeface.numerics.statistics import bootstrap_over_groups
from rangeface.pipeline import Step

TITLE = "What does a denoiser do to real captures?"
PRESET = "full-n-mlda"


@kept
def recognised(store: Store, *, source: Source, denoiser: Step, pipeline: str) -> Arrays:
    """Which probes of a database a preset recognises behind a denoiser.

    Returns
    -------
    dict
        "hits" (n,) bool; "acquired" (n,) bool; "owner" (n,): number of the person.
    """
    way = replace(load_pipeline(PRESET), denoise=denoiser)
    protocol = next(iter(DATABASES[source.kind].protocols.values()))
    scans = protocol(database(source))
    if way.adapt_reference:
        captures = acquire(way, learners(scans))
        way = way.adapted([c.trace for c in captures if c.trace is not None])
    scores = compare(way, acquire(way, scans))
    people = np.array(scores.people)
    truth = np.array(scores.probe_subjects)
    acquired = np.isfinite(scores.table).any(axis=1)
    first = np.where(np.isnan(scores.table), -np.inf, scores.table).argmax(axis=1)
    return {
        "hits": acquired & (people[first] == truth),
        "acquired": acquired,
        "owner": np.unique(truth, return_inverse=True)[1],
    }


def cells(source: Source) -> list[Cell]:
    """A cell a denoiser."""
    if source.simulated:
        raise ParameterError("data: denoise_on_captures needs gavab:PATH or rap3df:PATH")
    fingerprint = load_pipeline(PRESET).fingerprint
    return [
        cell(recognised, source=source, denoiser=denoiser, pipeline=fingerprint)
        for denoiser in DENOISERS.values()
    ]


def tabulate(source: Source, results: Results) -> Findings:
    """The rate behind each denoiser, and what it gains over none."""
    found = dict(zip(DENOISERS, map(results, cells(source)), strict=True))
    none = found["none"]
    rows = []
    for name, result in found.items():
        gain = 100.0 * (result["hits"].astype(float) - none["hits"])
        low, high = bootstrap_over_groups(
            partial(_mean, gain), none["owner"], rng=np.random.default_rng(0)
        )
        lost = int(np.count_nonzero(~result["acquired"]))
        right = Rate.of(int(result["hits"].sum()), len(gain))
        rows.append([name, Entry(right), f"{gain.mean():+.1f} [{low:+.1f}, {high:+.1f}]", lost])
    caption = (
        f"Rank 1 of `{PRESET}`, % [95 %], n = {len(none['hits'])} probes; points gained over no "
        "denoising [95 %, bootstrap over people]; probes not acquired (they count as errors)"
    )
    return Findings(
        TITLE, "Does any denoiser, with its defaults, gain or lose on a real sensor's captures?",
        tables=[Table("denoisers", caption, ["denoiser", "rank 1", "gain", "lost"], rows)],
    )  # fmt: skip


def _mean(values: np.ndarray, rows: np.ndarray) -> float:
    return float(values[rows].mean())


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=64, minutes=8.0)
