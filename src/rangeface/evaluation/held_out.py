"""Thresholds chosen on some people and reported on others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.decide import threshold_at_fmr
from rangeface.errors import ParameterError
from rangeface.evaluation.curves import same_person
from rangeface.evaluation.error_rates import Rate


@dataclass(frozen=True)
class HeldOut:
    """Rates on people who had no part in the choice of the threshold.

    Parameters
    ----------
    fmr, fnmr : Rate
        Over all folds.
    thresholds : tuple of float
        One a fold.
    """

    fmr: Rate
    fnmr: Rate
    thresholds: tuple[float, ...]


def people_folds(
    subjects: ArrayLike, *, folds: int, rng: np.random.Generator
) -> tuple[NDArray[np.bool_], ...]:
    """Masks (n,) of the rows held out in each fold; all rows of a person stay together.

    Parameters
    ----------
    subjects : (n,) array_like
        Person of each row.
    folds : int
        2 ≤ folds ≤ number of people.
    rng : numpy.random.Generator
        Deals the people out.

    Returns
    -------
    tuple of (n,) bool arrays
        Every row is held out exactly once.

    Raises
    ------
    ParameterError
        There are fewer than two folds, or more than people.

    Examples
    --------
    >>> people_folds(["a", "a", "b"], folds=2, rng=np.random.default_rng(0))
    (array([ True,  True, False]), array([False, False,  True]))
    """
    people, labels = np.unique(np.asarray(subjects), return_inverse=True)
    if not 2 <= folds <= len(people):
        raise ParameterError(f"folds: must be 2 … {len(people)} (the people), got {folds}")
    fold_of = rng.permutation(np.arange(len(people)) % folds)
    return tuple(fold_of[labels] == fold for fold in range(folds))


def held_out_rates(
    scores: ArrayLike,
    probe_subjects: ArrayLike,
    gallery_subjects: ArrayLike,
    *,
    fmr: float,
    rng: np.random.Generator,
    folds: int = 5,
) -> HeldOut:
    """Verification rates of people for whom the threshold was not chosen.

    Parameters
    ----------
    scores : (n, m) array_like
        NaN where the probe failed to acquire: a false non-match.
    probe_subjects, gallery_subjects : (n,) and (m,) array_like
        Who they are.
    fmr : float
        Wanted false match rate; each fold's threshold comes from comparisons among all people
        but those held out.
    rng : numpy.random.Generator
        Deals the people out.
    folds : int
        2 ≤ folds ≤ number of people.

    Returns
    -------
    HeldOut
        Rates over comparisons among the people held out.

    Raises
    ------
    ParameterError
        The sizes do not fit, there are too many folds, or so few comparisons cannot show `fmr`.
    """
    table, same = same_person(scores, probe_subjects, gallery_subjects)
    probes, gallery = np.asarray(probe_subjects), np.asarray(gallery_subjects)
    counts = np.zeros(4, dtype=int)
    thresholds = []
    everybody = np.concatenate([probes, gallery])
    for mask in people_folds(everybody, folds=folds, rng=rng):
        rows, columns = mask[: len(probes)], mask[len(probes) :]
        learnt, mated = table[~rows][:, ~columns], same[~rows][:, ~columns]
        threshold = threshold_at_fmr(learnt[~mated], fmr)
        held, mated = table[rows][:, columns], same[rows][:, columns]
        compared = held[~mated & ~np.isnan(held)]
        counts += [
            np.count_nonzero(compared >= threshold),
            compared.size,
            np.count_nonzero(~(held[mated] >= threshold)),
            np.count_nonzero(mated),
        ]
        thresholds.append(threshold)
    matches, nonmated, misses, attempts = map(int, counts)
    return HeldOut(Rate.of(matches, nonmated), Rate.of(misses, attempts), tuple(thresholds))
