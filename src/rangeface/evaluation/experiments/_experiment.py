"""What an experiment is: cells, and what to make of their results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Claim, Findings
from rangeface.evaluation.grid import Arrays, Cell, Store

#: Looks a cell's result up.
Results = Callable[[Cell], Arrays]


@dataclass(frozen=True)
class Experiment:
    """A question, as one file answers it.

    Parameters
    ----------
    title : str
        One line.
    cells : callable
        Source → the cells, neighbours sharing what they can.
    tabulate : callable
        (Source, results) → Findings.
    persons : int
        How many people, unless the user says.
    minutes : float
        About what a run from nothing takes on two cores.
    """

    title: str
    cells: Callable[[Source], Sequence[Cell]]
    tabulate: Callable[[Source, Results], Findings]
    persons: int = 61
    minutes: float = 5.0


def results_of(store: Store) -> Results:
    """Results as a store keeps them, each read once."""
    return lru_cache(maxsize=None)(store.get)


def hits(result: Arrays) -> NDArray[np.bool_]:
    """Which probes were recognised by their first view alone."""
    return sequence_hits({**result, "scores": result["scores"][:, :1]})


def sequence_hits(result: Arrays) -> NDArray[np.bool_]:
    """Which probes were recognised by the majority of their views; the best sum decides a tie."""
    scores, owner = result["scores"], result["owner"]
    shown: NDArray[np.bool_] = np.asarray(np.isfinite(scores).any(axis=2))
    known = np.where(np.isnan(scores), -np.inf, scores)
    votes = np.zeros((len(owner), scores.shape[2]))
    np.add.at(votes, (np.arange(len(owner))[:, None], known.argmax(axis=2)), shown)
    # squeezed below one vote, the sum of scores only orders equals
    total = np.nansum(scores, axis=1, dtype=np.float64)
    span = np.ptp(total, axis=1, keepdims=True)
    votes += 0.5 * (total - total.min(axis=1, keepdims=True)) / np.where(span > 0, span, 1.0)
    right: NDArray[np.bool_] = np.equal(votes.argmax(axis=1), owner)
    return right & shown.any(axis=1)


def ordering(
    results: Results,
    text: str,
    better: Sequence[Cell],
    worse: Sequence[Cell],
    *,
    test: Callable[[Arrays], NDArray[np.bool_]] = hits,
    source: str = "paper",
    margin: float | None = None,
) -> Claim:
    """The claim that one group of cells recognises better than another, paired by person.

    A person's mean over the cells of a group is one value: what the claim does not tell apart is
    pooled. Only people whom both groups tried count.
    """
    first, second = (_by_person(results, group, test) for group in (better, worse))
    people = sorted(first.keys() & second.keys())
    return Claim(
        text, source, [first[p] for p in people], [second[p] for p in people], people, margin
    )


def _by_person(
    results: Results, cells: Sequence[Cell], test: Callable[[Arrays], NDArray[np.bool_]]
) -> dict[int, float]:
    right, owner = [], []
    for cell in cells:
        result = results(cell)
        right.append(test(result))
        owner.append(result["owner"])
    hit, person = np.concatenate(right), np.concatenate(owner)
    return {int(p): float(hit[person == p].mean()) for p in np.unique(person)}


def rate(right: NDArray[np.bool_]) -> Rate:
    """A rate of hits."""
    return Rate.of(int(np.count_nonzero(right)), len(right))
