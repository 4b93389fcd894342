"""`rangeface experiment`: run a grid of cells, tabulate, report."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from rangeface.app.console import console
from rangeface.app.progress import err
from rangeface.errors import ParameterError
from rangeface.evaluation import grid
from rangeface.evaluation.experiments import EXPERIMENTS, evidence
from rangeface.evaluation.experiments._experiment import Experiment, results_of
from rangeface.evaluation.experiments.sources import Source, source
from rangeface.evaluation.findings import Findings
from rangeface.evaluation.grid import Cell, Executor
from rangeface.evaluation.publish import Provenance, publish, verdict_table

#: Where results of cells are kept, in the output folder: experiments share them.
CELLS = "cells"


def run(
    names: list[str], *, data: str, persons: int | None, seed: int, executor: str, out: Path
) -> None:
    """Run experiments one after the other; "all" is all of them."""
    chosen = list(EXPERIMENTS) if names == ["all"] else names
    for name in chosen:
        if name not in EXPERIMENTS:
            known = ", ".join(EXPERIMENTS)
            raise ParameterError(f"experiment: unknown {name!r}; known: all, {known}")
    computers = grid.executor(executor)
    for name in chosen:
        experiment = EXPERIMENTS[name]
        people = source(data, persons=persons or experiment.persons, seed=seed)
        try:
            cells = experiment.cells(people)
        except ParameterError as error:
            if names != ["all"]:
                raise
            console.print(f"{name} left out: {error}", highlight=False)
            continue
        options = f"--data {data} --persons {people.persons} --seed {seed}"
        _one(name, people, cells, f"rangeface experiment {name} {options}", computers, out)


def _one(
    name: str, people: Source, cells: Sequence[Cell], command: str, computers: Executor, out: Path
) -> None:
    start = time.perf_counter()
    experiment = EXPERIMENTS[name]
    console.print(f"{name}: about {_estimate(experiment, people)}", highlight=False)
    store = grid.Store((out / CELLS).resolve())
    with _bar(name) as progress:
        grid.run(cells, store, computers, progress=progress)
    results = results_of(store)
    findings = experiment.tabulate(people, results)
    evidence.attach(findings, people, cells, results)
    digest = hashlib.sha256("".join(map(grid.key, cells)).encode()).hexdigest()
    provenance = Provenance(
        command=command,
        data=f"{people} (hash {people.identity[:12]})",
        hash=f"{len(cells)} cells, {digest[:16]}",
        seconds=time.perf_counter() - start,
        executor=f"{computers.workers} processes; estimate: {_estimate(experiment, people)}",
    )
    report = publish(findings, out / name, provenance)
    _print(findings)
    console.print(f"{report} ({provenance.seconds:.0f} s)", highlight=False)


def _estimate(experiment: Experiment, people: Source) -> str:
    minutes = max(0.3, experiment.minutes * people.persons / experiment.persons)
    return f"{minutes:.2g} min on two cores from nothing, seconds when repeated"


def _print(findings: Findings) -> None:
    """The verdicts, or where nothing was claimed, the first table."""
    shown = verdict_table(findings.verdicts) if findings.verdicts else findings.tables[0]
    table = Table(*shown.header, title=findings.title)
    for row in shown.rows:
        table.add_row(*map(str, row))
    console.print(table, markup=False)


@contextmanager
def _bar(name: str) -> Iterator[grid.Progress]:
    """Cells done and the time left, on a terminal's standard error."""
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    )  # fmt: skip
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as progress:
        task = progress.add_task(name, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)
