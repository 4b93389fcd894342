"""Compute what is missing of a grid, shared stages first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rangeface.evaluation.grid._executors import Executor, Progress
from rangeface.evaluation.grid._store import Cell, Store, is_kept, key
from rangeface.pipeline import Step

#: A task for a worker: cells that follow each other share what is in memory.
_TASK = 48


def run(
    cells: Sequence[Cell],
    store: Store,
    executor: Executor,
    *,
    progress: Progress = lambda done, total: None,
) -> None:
    """Compute and keep every cell that the store does not have yet.

    Parameters
    ----------
    cells : sequence of Cell
        Of kept functions, in an order in which neighbours share intermediate results. Kept cells
        among their parameters are computed before them.
    store : Store
        Where results are, and go.
    executor : Executor
        Who computes; the results do not depend on it.
    progress : callable
        Called with (cells done, cells to do).
    """
    todo = [[cell for cell in wave if not store.path(cell).is_file()] for wave in waves(cells)]
    total, done = sum(map(len, todo)), 0
    progress(0, total)
    for wave in todo:
        for finished in executor(store, list(_tasks(wave, executor.workers))):
            done += finished
            progress(done, total)


def waves(cells: Sequence[Cell]) -> list[list[Cell]]:
    """The cells, and before them the kept cells that they need: no wave needs a later one."""
    found: dict[str, tuple[int, Cell]] = {}

    def visit(value: Any, depth: int) -> None:
        if isinstance(value, Step):
            if is_kept(value):
                known = found.get(key(value), (0, value))[0]
                found[key(value)] = (max(depth, known), value)
                depth += 1
            for _, inner in value.params:
                visit(inner, depth)
        elif isinstance(value, tuple):
            for inner in value:
                visit(inner, depth)

    for cell in cells:
        for _, inner in cell.params:
            visit(inner, 1)
    deepest = max((depth for depth, _ in found.values()), default=0)
    shared = [[c for d, c in found.values() if d == level] for level in range(deepest, 0, -1)]
    return [*shared, list({key(cell): cell for cell in cells}.values())]


def _tasks(cells: Sequence[Cell], workers: int) -> Iterator[Sequence[Cell]]:
    size = min(max(1, len(cells) // (4 * workers)), _TASK)
    for start in range(0, len(cells), size):
        yield cells[start : start + size]
