"""Error rates of a table of scores, each with its interval and its counts.

A table has one row a probe and one column an enrolled person; higher = more alike. NaN is a
comparison that could not be made because the probe failed to acquire: it is an error of
identification and a false non-match, and it is never left out. A false match needs a comparison,
so false match rates are over those that were made.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.decide import threshold_at_fmr
from rangeface.errors import DegenerateError, ParameterError
from rangeface.evaluation.curves import det, ranks_of_mated, same_person
from rangeface.numerics.statistics import wilson

Scores = NDArray[np.float64]


@dataclass(frozen=True)
class Rate:
    """A proportion with its 95 % interval (Wilson) and the counts that it comes from.

    Parameters
    ----------
    rate, low, high : float
        0 … 1.
    count, n : int
        The rate is count / n: hits or errors, as the name of the function says.

    Examples
    --------
    >>> print(Rate.of(20, 24))
    83.3 % [64.1, 93.3] (20 of 24)
    """

    rate: float
    low: float
    high: float
    count: int
    n: int

    @classmethod
    def of(cls, count: int, n: int) -> Rate:
        """The rate count / n.

        Raises
        ------
        DegenerateError
            n is 0: there is nothing to rate.
        """
        if n < 1:
            raise DegenerateError("a rate needs at least one case, got none")
        return cls(count / n, *wilson(count, n), int(count), int(n))

    def __str__(self) -> str:
        bounds = f"[{100 * self.low:.1f}, {100 * self.high:.1f}]"
        return f"{100 * self.rate:.1f} % {bounds} ({self.count} of {self.n})"


def mated_nonmated(
    scores: ArrayLike, probe_subjects: ArrayLike, gallery_subjects: ArrayLike
) -> tuple[Scores, Scores]:
    """Split a table into scores of one person with themself, and of different people.

    Parameters
    ----------
    scores : (n, m) array_like
        NaN where the probe failed to acquire.
    probe_subjects, gallery_subjects : (n,) and (m,) array_like
        Who they are.

    Returns
    -------
    mated, nonmated : 1-D float64 arrays

    Raises
    ------
    ParameterError
        The sizes do not fit.

    Examples
    --------
    >>> mated_nonmated([[3.0, 1.0], [2.0, 4.0]], ["a", "b"], ["a", "b"])
    (array([3., 4.]), array([1., 2.]))
    """
    table, same = same_person(scores, probe_subjects, gallery_subjects)
    return table[same], table[~same]


def rank_k(
    scores: ArrayLike, probe_subjects: ArrayLike, gallery_subjects: ArrayLike, *, k: int = 1
) -> Rate:
    """Closed-set identification: the share of probes whose person is among the best k.

    Parameters
    ----------
    scores : (n, m) array_like
        NaN where the probe failed to acquire: a miss.
    probe_subjects, gallery_subjects : (n,) and (m,) array_like
        Who they are; every probe's person is enrolled.
    k : int
        Rank, ≥ 1.

    Returns
    -------
    Rate
        Hits of all probes. Equal scores count against the probe.

    Raises
    ------
    ParameterError
        The sizes do not fit, k < 1, or a probe's person is not enrolled.

    Examples
    --------
    >>> rank_k([[3.0, 1.0], [2.0, 1.0]], ["a", "b"], ["a", "b"]).rate
    0.5
    """
    if k < 1:
        raise ParameterError(f"k: must be ≥ 1, got {k}")
    ranks = ranks_of_mated(scores, probe_subjects, gallery_subjects)
    return Rate.of(int(np.count_nonzero(ranks <= k)), len(ranks))


def failure_to_acquire(scores: ArrayLike) -> Rate:
    """FTA: the share of probes with no comparison at all.

    Parameters
    ----------
    scores : (n, m) array_like
        NaN rows are failures.

    Returns
    -------
    Rate
        Failures of all probes.
    """
    table = np.asarray(scores, dtype=np.float64)
    failed = np.count_nonzero(np.isnan(table).all(axis=1))
    return Rate.of(int(failed), len(table))


def fmr(nonmated: ArrayLike, threshold: float) -> Rate:
    """False match rate: the share of different-person comparisons at or above the threshold.

    Parameters
    ----------
    nonmated : (k,) array_like
        Scores of different people; NaN (not compared) is left out.
    threshold : float
        Accept at or above.

    Returns
    -------
    Rate
        False matches of the comparisons made.
    """
    made = _made(nonmated)
    return Rate.of(int(np.count_nonzero(made >= threshold)), len(made))


def fnmr(mated: ArrayLike, threshold: float) -> Rate:
    """False non-match rate: the share of same-person comparisons below the threshold.

    Parameters
    ----------
    mated : (k,) array_like
        Scores of one person with themself; NaN (failed to acquire) is an error.
    threshold : float
        Accept at or above.

    Returns
    -------
    Rate
        False non-matches of all attempts.
    """
    tried = np.asarray(mated, dtype=np.float64).ravel()
    return Rate.of(int(np.count_nonzero(~(tried >= threshold))), len(tried))


def fnmr_at_fmr(mated: ArrayLike, nonmated: ArrayLike, fmr: float) -> Rate:
    """False non-match rate at the threshold that gives a wanted false match rate.

    Parameters
    ----------
    mated, nonmated : 1-D array_like
        Scores, as `mated_nonmated` splits them.
    fmr : float
        Wanted false match rate, at least 3 / number of different-person comparisons.

    Returns
    -------
    Rate
        False non-matches of all attempts.

    Raises
    ------
    ParameterError
        The rate cannot be shown with so few comparisons.

    Examples
    --------
    >>> fnmr_at_fmr([50.0, 99.0], np.arange(100), 0.05).rate
    0.5
    """
    return fnmr(mated, threshold_at_fmr(nonmated, fmr))


def eer(mated: ArrayLike, nonmated: ArrayLike) -> Rate:
    """Equal error rate: where false match and false non-match rates meet.

    Parameters
    ----------
    mated, nonmated : 1-D array_like
        Scores, as `mated_nonmated` splits them; a NaN in `mated` is an error at any threshold.

    Returns
    -------
    Rate
        The rate at which the two broken lines cross; its interval and counts are those of as
        many errors among the mated comparisons, the fewer of the two kinds.

    Raises
    ------
    DegenerateError
        One of the kinds is empty.

    Examples
    --------
    >>> eer([2.0, 3.0, 4.0, 1.0], [0.0, 1.5, 0.5, 0.2]).rate
    0.25
    """
    curve = det(mated, nonmated)
    gap = curve.fnmr - curve.fmr  # never falls with the threshold, −1 … 1
    right = int(np.argmax(gap >= 0))
    left = max(right - 1, 0)
    t = -gap[left] / (gap[right] - gap[left]) if right > left else 0.0
    rate = float((1 - t) * curve.fnmr[left] + t * curve.fnmr[right])
    n = np.size(mated)
    count = round(rate * n)
    low, high = wilson(count, n)
    return Rate(rate, min(low, rate), max(high, rate), count, n)


def _made(scores: ArrayLike) -> Scores:
    values = np.asarray(scores, dtype=np.float64).ravel()
    return values[~np.isnan(values)]
