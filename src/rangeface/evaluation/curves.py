"""Points of the curves that show a matcher at every threshold or rank."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from rangeface.errors import DegenerateError, ParameterError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Curve:
    """Both error rates at each threshold; the true match rate of a ROC is 1 − `fnmr`.

    Parameters
    ----------
    thresholds, fmr, fnmr : (k,) arrays
        Thresholds rise, so `fmr` falls and `fnmr` rises.
    """

    thresholds: Array
    fmr: Array
    fnmr: Array

    def probit(self) -> tuple[Array, Array]:
        """Axes of a DET plot: normal deviates of `fmr` and `fnmr`; infinite at 0 and 1."""
        return ndtri(self.fmr), ndtri(self.fnmr)


def det(mated: ArrayLike, nonmated: ArrayLike) -> Curve:
    """False match against false non-match rate at every threshold that changes one of them.

    Parameters
    ----------
    mated, nonmated : 1-D array_like
        Scores; NaN in `mated` (failed to acquire) is an error, in `nonmated` left out.

    Returns
    -------
    Curve
        ROC and DET are two drawings of it.

    Raises
    ------
    DegenerateError
        One of the kinds is empty.

    References
    ----------
    A. Martin et al., Eurospeech 1997 (the DET curve).

    Examples
    --------
    >>> det([1.0, 2.0], [0.0]).fnmr
    array([0. , 0. , 0.5, 1. ])
    """
    tried = np.asarray(mated, dtype=np.float64).ravel()
    compared = np.sort(tried[~np.isnan(tried)])
    others = np.asarray(nonmated, dtype=np.float64).ravel()
    others = np.sort(others[~np.isnan(others)])
    if len(tried) == 0 or len(others) == 0:
        raise DegenerateError("needs mated and non-mated comparisons")
    thresholds = np.append(np.unique(np.concatenate([compared, others])), np.inf)
    misses = len(tried) - len(compared) + np.searchsorted(compared, thresholds, side="left")
    matches = len(others) - np.searchsorted(others, thresholds, side="left")
    return Curve(thresholds, matches / len(others), misses / len(tried))


def cmc(scores: ArrayLike, probe_subjects: ArrayLike, gallery_subjects: ArrayLike) -> Array:
    """Cumulative match characteristic: the share of probes found within rank 1, 2, ….

    Parameters
    ----------
    scores : (n, m) array_like
        NaN where the probe failed to acquire: found at no rank.
    probe_subjects, gallery_subjects : (n,) and (m,) array_like
        Who they are; every probe's person is enrolled.

    Returns
    -------
    (number of people enrolled,) float64

    Raises
    ------
    ParameterError
        The sizes do not fit, or a probe's person is not enrolled.

    Examples
    --------
    >>> cmc([[3.0, 1.0], [2.0, 1.0]], ["a", "b"], ["a", "b"])
    array([0.5, 1. ])
    """
    ranks = ranks_of_mated(scores, probe_subjects, gallery_subjects)
    people = len(np.unique(np.asarray(gallery_subjects)))
    return (ranks[:, None] <= np.arange(1, people + 1)).mean(axis=0)


def ranks_of_mated(
    scores: ArrayLike, probe_subjects: ArrayLike, gallery_subjects: ArrayLike
) -> Array:
    """Rank (1 = best) at which each probe's own person stands; infinite where it failed.

    Parameters
    ----------
    scores, probe_subjects, gallery_subjects
        As in `cmc`. Several columns of one person count once, by their best.

    Returns
    -------
    (n,) float64

    Raises
    ------
    ParameterError
        The sizes do not fit, or a probe's person is not enrolled.
    """
    table, _ = same_person(scores, probe_subjects, gallery_subjects)
    people, columns = np.unique(np.asarray(gallery_subjects), return_inverse=True)
    best = np.full((len(table), len(people)), -np.inf)
    np.maximum.at(best.T, columns, np.where(np.isnan(table), -np.inf, table).T)
    own = np.searchsorted(people, np.asarray(probe_subjects))
    known = (own < len(people)) & (people[np.minimum(own, len(people) - 1)] == probe_subjects)
    if not known.all():
        stranger = np.asarray(probe_subjects)[~known][0]
        raise ParameterError(f"probe_subjects: '{stranger}' is not enrolled (closed set)")
    mine = best[np.arange(len(best)), own]
    ranks = np.count_nonzero(best >= mine[:, None], axis=1).astype(np.float64)
    return np.where(np.isneginf(mine), np.inf, ranks)


def same_person(
    scores: ArrayLike, probe_subjects: ArrayLike, gallery_subjects: ArrayLike
) -> tuple[Array, NDArray[np.bool_]]:
    """The table as float64, and which of its cells compare a person with themself.

    Raises
    ------
    ParameterError
        The sizes do not fit.
    """
    table = np.asarray(scores, dtype=np.float64)
    probes, gallery = np.asarray(probe_subjects), np.asarray(gallery_subjects)
    if table.shape != (len(probes), len(gallery)):
        raise ParameterError(
            f"scores: {table.shape} does not fit {len(probes)} probes × {len(gallery)} enrolled"
        )
    return table, probes[:, None] == gallery[None, :]
