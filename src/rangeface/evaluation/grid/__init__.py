"""An experiment as a grid of cells: pure functions whose results are kept under a hash.

A *cell* is a `Step` of a function ``f(store, *, …) -> {name: array}``. Its key is the SHA-256 of
the function's name and revision and of every parameter, other cells among them, so that a changed
parameter never meets a stale result. What many cells share is a cell of its own: in a file, if
its function is marked `kept`, else in memory for a while::

    scan  = cell(scans, source=source, view="frontal2")
    crop  = cell(crops, scans=scan, register=step(register.none))
    hits  = cell(recognition, training=(…), probes=crop, feature=step(describe.n3), …)
    run([hits], Store(folder), executor("processes"))
"""

from rangeface.evaluation.grid._executors import Executor, Progress, executor
from rangeface.evaluation.grid._run import run, waves
from rangeface.evaluation.grid._store import Arrays, Cell, Store, cell, kept, key

__all__ = [
    "Arrays",
    "Cell",
    "Executor",
    "Progress",
    "Store",
    "cell",
    "executor",
    "kept",
    "key",
    "run",
    "waves",
]
