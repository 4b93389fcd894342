"""What each head of a fusion adds, how its weights could be chosen, and why probes fail."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rangeface.decide import LlrFusion, sum_rule
from rangeface.errors import DegenerateError
from rangeface.evaluation.captures import Capture
from rangeface.evaluation.curves import ranks_of_mated, same_person
from rangeface.evaluation.held_out import people_folds
from rangeface.evaluation.scores import Scores
from rangeface.types import Float64

#: A head turned further than this hides a part of the face (degrees of yaw, of pitch).
TURNED_DEG, NODDED_DEG = 25.0, 20.0
#: Less measured surface than this part of the frontal grid is little.
LITTLE_COVERAGE = 0.6


def without_head(scores: Scores, head: int) -> Scores:
    """The scores of an equal-weight fusion that lacks one head.

    Parameters
    ----------
    scores : Scores
        Of at least two heads.
    head : int
        Which to leave out.

    Returns
    -------
    Scores

    Raises
    ------
    DegenerateError
        There is only one head.
    """
    if len(scores.heads) < 2:
        raise DegenerateError("leaving one out needs at least two heads")
    heads, fixed = np.delete(scores.heads, head, axis=0), np.delete(scores.fixed, head, axis=0)
    return _fused(scores, heads, fixed, np.ones(len(heads)))


def only_head(scores: Scores, head: int) -> Scores:
    """The scores of one head alone."""
    chosen = slice(head, head + 1)
    return _fused(scores, scores.heads[chosen], scores.fixed[chosen], np.ones(1))


def cross_validated(
    scores: Scores, *, rng: np.random.Generator, folds: int = 10, shrinkage: float = 0.01
) -> tuple[Scores, Float64]:
    """Weights of the heads learned from some people, applied to the probes of others.

    Parameters
    ----------
    scores : Scores
    rng : numpy.random.Generator
        Deals the people out.
    folds : int
        2 ≤ folds ≤ number of people.
    shrinkage : float
        Of `LlrFusion`, towards equal weights.

    Returns
    -------
    scores : Scores
        No weight has seen a score of the probe's person, as a probe or in the gallery.
    weights : (folds, H) float64
        Share of each head, one row a fold.

    Raises
    ------
    ParameterError
        There are fewer than two folds, or more than people.
    """
    subjects, people = np.array(scores.probe_subjects), np.array(scores.people)
    _, same = same_person(scores.table, subjects, people)
    everybody = np.concatenate([subjects, people])
    table, raw = np.full(scores.table.shape, np.nan), np.full(scores.table.shape, np.nan)
    shares = []
    for mask in people_folds(everybody, folds=folds, rng=rng):
        held, columns = mask[: len(subjects)], mask[len(subjects) :]
        learned = scores.heads[:, ~held][:, :, ~columns]
        made = ~np.isnan(learned).all(axis=0)
        fusion = LlrFusion(shrinkage=shrinkage)
        fusion.fit(learned[:, made].T, same[~held][:, ~columns][made])
        weights = np.maximum(fusion.weights_ / fusion.scale_, 0.0)
        fold = _fused(scores, scores.heads, scores.fixed, weights)
        table[held], raw[held] = fold.table[held], fold.raw[held]
        shares.append(weights / weights.sum())
    return replace(scores, table=table, raw=raw), np.array(shares)


def _fused(scores: Scores, heads: Float64, fixed: Float64, weights: Float64) -> Scores:
    share = len(weights) * weights / weights.sum()
    table, raw = (sum_rule(s * share[:, None, None]).astype(np.float64) for s in (heads, fixed))
    return replace(scores, heads=heads, fixed=fixed, table=table, raw=raw)


# ── errors ───────────────────────────────────────────────────────────────────────────────


@dataclass(frozen=True)
class Miss:
    """A probe whose person is not the best.

    Parameters
    ----------
    probe : int
        Its row.
    subject : str
        Who it shows.
    rank : float
        Place of that person; infinite where nothing was compared.
    causes : tuple of str
        What is wrong with the probe or with the gallery capture; ("unexplained",) if nothing
        that is measured is.
    """

    probe: int
    subject: str
    rank: float
    causes: tuple[str, ...]


def right(scores: Scores) -> NDArray[np.bool_]:
    """Whether each probe's person is the best, (n,)."""
    return np.asarray(ranks_of_mated(scores.table, scores.probe_subjects, scores.people) == 1)


def misses(scores: Scores, captures: list[Capture]) -> list[Miss]:
    """Every error of identification with its causes, as far as they are measured.

    Parameters
    ----------
    scores : Scores
    captures : list of Capture
        With the gallery's.

    Returns
    -------
    list of Miss
    """
    ranks = ranks_of_mated(scores.table, scores.probe_subjects, scores.people)
    gallery = {c.scan.subject: c for c in captures if c.scan.role == "gallery"}
    wrong = [k for k, rank in enumerate(ranks) if rank != 1]
    best = Counter(
        scores.people[int(np.nanargmax(scores.table[k]))]
        for k in wrong
        if not np.isnan(scores.table[k]).all()
    )
    found = []
    for k in wrong:
        subject = scores.probe_subjects[k]
        causes = [*_faults(scores.probes[k])]
        causes += [f"gallery: {fault}" for fault in _faults(gallery[subject])]
        if scores.probes[k].acquired:
            winner = scores.people[int(np.nanargmax(scores.table[k]))]
            if best[winner] >= 3:
                causes.append(f"gallery of {winner} attracts {best[winner]} probes")
        found.append(Miss(k, subject, float(ranks[k]), tuple(causes) or ("unexplained",)))
    return found


def _faults(capture: Capture) -> list[str]:
    """What is measurably wrong with a capture."""
    if capture.trace is None or capture.trace.assessment is None:
        return [f"not acquired ({capture.failure})"]
    a = capture.trace.assessment
    faults = []
    if abs(a.yaw_deg) > TURNED_DEG:
        faults.append(f"yaw {a.yaw_deg:.0f}°")
    if abs(a.pitch_deg) > NODDED_DEG:
        faults.append(f"pitch {a.pitch_deg:.0f}°")
    if a.coverage < LITTLE_COVERAGE:
        faults.append(f"{100 * a.coverage:.0f} % of the face measured")
    return faults + [reason.value for reason in a.refusals if not faults]
