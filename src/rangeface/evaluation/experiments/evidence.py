"""What stands behind the tables: scores, worst pairs, and where scans were lost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from rangeface.evaluation.comparisons import Comparisons
from rangeface.evaluation.experiments._experiment import Results
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.experiments.stages import (
    ACQUIRED,
    NO_FACE,
    NOT_REGISTERED,
    crops,
    image_of,
)
from rangeface.evaluation.findings import Findings, Table
from rangeface.evaluation.grid import Arrays, Cell, key
from rangeface.evaluation.pictures import png
from rangeface.evaluation.score_plots import pairs_figure
from rangeface.pipeline import Step
from rangeface.types import RangeImage


def attach(findings: Findings, source: Source, cells: Sequence[Cell], results: Results) -> None:
    """Add the scores and worst pairs of the condition shown, and the failures of each stage."""
    lost = failures(cells, results)
    if lost.rows:
        findings.tables.append(lost)
    if findings.shown is None:
        return
    name, shown = findings.shown
    result = results(shown)
    comparisons = _comparisons(source, result)
    findings.comparisons = (name, comparisons)
    params = dict(shown.params)
    probes, enrolled = results(params["probes"]), results(params["training"][0])
    owners = enrolled["owner"].tolist()
    figure = pairs_figure(
        comparisons,
        lambda row: _image(probes, row),
        lambda person: _image(enrolled, owners.index(person)) if person in owners else None,
    )
    caption = (
        f"Worst mated pairs (first row) and worst non-mated pairs of: {name}. "
        "Left the probe, right the enrolled face."
    )
    findings.figures.append((caption, png(figure)))


def _comparisons(source: Source, result: Arrays) -> Comparisons:
    """The first view of every probe against every person."""
    table = np.asarray(result["scores"][:, 0], np.float64)
    people = tuple(f"person {k}" for k in range(table.shape[1]))
    subjects = tuple(people[k] for k in result["owner"].tolist())
    seen: dict[str, int] = {}
    probes = []
    for subject in subjects:
        seen[subject] = seen.get(subject, 0) + 1
        probes.append(f"{subject}, {seen[subject]}")
    return Comparisons(table, tuple(probes), people, subjects, people)


def _image(arrays: Arrays, row: int) -> RangeImage | None:
    return image_of(arrays, row) if np.isfinite(arrays["depth"][row, 0]).any() else None


def failures(cells: Sequence[Cell], results: Results) -> Table:
    """How far the scans of every view and crop came, clean scans."""
    rows = []
    for shown in {key(c): c for cell in cells for c in _inner(cell) if c.method is crops}.values():
        params = dict(shown.params)
        stage = results(shown)["stage"]
        lost = [int(np.count_nonzero(stage == s)) for s in (NO_FACE, NOT_REGISTERED, ACQUIRED)]
        frontal = params["frontal"].all_params()
        window = f"{frontal['width_mm']:g} × {frontal['height_mm']:g} mm"
        view = dict(params["scans"].params)["view"]
        rows.append((view, window, params["register"].name, stage.size, *lost))
    header = ("view", "crop", "registration", "scans", "no face", "not registered", "acquired")
    caption = "Failures of each stage on clean scans; a probe that fails counts as an error"
    return Table("failures", caption, header, sorted(set(rows)))


def _inner(value: Any) -> Iterator[Cell]:
    """All cells inside a cell's parameters."""
    if isinstance(value, Step):
        yield value
        for _, inner in value.params:
            yield from _inner(inner)
    elif isinstance(value, tuple):
        for inner in value:
            yield from _inner(inner)
