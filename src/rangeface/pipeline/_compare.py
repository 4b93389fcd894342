"""Every head's scores of a probe against people, and which of them deserve the slow heads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rangeface.gallery import View
from rangeface.pipeline._head import Head
from rangeface.pipeline._step import Step
from rangeface.types import Float32, Template

#: People whom a head that works pair by pair (30 µs each) sees: the best by the other heads. In
#: 10,000 people that is a third of the time of the search itself.
SHORTLIST = 100


def compared(
    heads: Sequence[Head], probe: Template, references: View, normalise: Step
) -> tuple[Float32, NDArray[np.bool_]]:
    """Scores (H, S), NaN where a head did not compare; and who was on the shortlist (S,).

    Everybody is, where there are no more than `SHORTLIST` people, no head that works pair by
    pair, or no other.
    """
    count = len(references.subjects)
    scores = np.full((len(heads), count), np.nan, np.float32)
    slow = [k for k, head in enumerate(heads) if head.classify.pairwise]
    fast = [k for k in range(len(heads)) if k not in slow]
    for k in fast:
        scores[k] = heads[k].scores(
            probe.vectors[k], references.vectors[k], references.owners[k], count
        )
    listed = np.ones(count, bool)
    if slow and fast and count > SHORTLIST:
        listed = _best(scores[fast], normalise)
    for k in slow:
        rows, owners = references.vectors[k], references.owners[k]
        if not listed.all():
            kept = listed[owners]
            rows, owners = rows[kept], owners[kept]
        scores[k] = heads[k].scores(probe.vectors[k], rows, owners, count)
    return scores, listed


def capped(fused: Float32, listed: NDArray[np.bool_]) -> Float32:
    """Fused scores in which nobody beyond the shortlist beats anybody on it.

    Who was seen by fewer heads has a mean over fewer scores; that must be no advantage.
    """
    reached = fused[listed & ~np.isnan(fused)]
    if listed.all() or len(reached) == 0:
        return fused
    return np.where(listed, fused, np.minimum(fused, reached.min()))


def _best(scores: Float32, normalise: Step) -> NDArray[np.bool_]:
    """The `SHORTLIST` people with the best mean of normalised scores."""
    table = normalise(scores, None)
    known = ~np.isnan(table)
    total = np.where(known, table, 0.0).sum(axis=0)
    mean = np.where(known.any(axis=0), total / np.maximum(known.sum(axis=0), 1), -np.inf)
    listed = np.zeros(scores.shape[1], bool)
    listed[np.argpartition(-mean, SHORTLIST)[:SHORTLIST]] = True
    return listed
