"""Open-set identification: strangers let in, enrolled people turned away."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.decide import threshold_at_fmr
from rangeface.errors import ParameterError
from rangeface.evaluation.curves import ranks_of_mated
from rangeface.evaluation.error_rates import Rate


def fpir(stranger_scores: ArrayLike, threshold: float) -> Rate:
    """False positive identification rate: strangers for whom any enrolled person is returned.

    Parameters
    ----------
    stranger_scores : (n, m) array_like
        Scores of people who are not enrolled; a row of NaN (failed to acquire) lets nobody in
        and is left out.
    threshold : float
        Accept at or above.

    Returns
    -------
    Rate
        Errors of the searches made.
    """
    best = best_scores(stranger_scores)
    best = best[~np.isnan(best)]
    return Rate.of(int(np.count_nonzero(best >= threshold)), len(best))


def fnir(
    scores: ArrayLike,
    probe_subjects: ArrayLike,
    gallery_subjects: ArrayLike,
    threshold: float,
    *,
    k: int = 1,
) -> Rate:
    """False negative identification rate: enrolled people not returned at all, or not in rank k.

    Parameters
    ----------
    scores : (n, m) array_like
        Scores of enrolled people's probes; NaN (failed to acquire) is an error.
    probe_subjects, gallery_subjects : (n,) and (m,) array_like
        Who they are.
    threshold : float
        Accept at or above.
    k : int
        Rank, ≥ 1.

    Returns
    -------
    Rate
        Errors of all searches.

    Raises
    ------
    ParameterError
        The sizes do not fit, k < 1, or a probe's person is not enrolled.

    Examples
    --------
    >>> fnir([[3.0, 1.0], [0.0, 1.0]], ["a", "b"], ["a", "b"], 2.0).rate
    0.5
    """
    if k < 1:
        raise ParameterError(f"k: must be ≥ 1, got {k}")
    ranks = ranks_of_mated(scores, probe_subjects, gallery_subjects)
    same = np.asarray(probe_subjects)[:, None] == np.asarray(gallery_subjects)[None, :]
    table = np.where(same, np.asarray(scores, dtype=np.float64), np.nan)
    found = (best_scores(table) >= threshold) & (ranks <= k)
    return Rate.of(int(np.count_nonzero(~found)), len(found))


def fnir_at_fpir(
    scores: ArrayLike,
    probe_subjects: ArrayLike,
    gallery_subjects: ArrayLike,
    stranger_scores: ArrayLike,
    fpir: float,
) -> Rate:
    """False negative identification rate where strangers get in at a wanted rate.

    Parameters
    ----------
    scores, probe_subjects, gallery_subjects
        As in `fnir`.
    stranger_scores : (s, m) array_like
        As in `fpir`.
    fpir : float
        Wanted rate, at least 3 / s.

    Returns
    -------
    Rate
        Errors of all searches of enrolled people.

    Raises
    ------
    ParameterError
        So few strangers cannot show the rate, or the sizes do not fit.
    """
    threshold = threshold_at_fmr(best_scores(stranger_scores), fpir)
    return fnir(scores, probe_subjects, gallery_subjects, threshold)


def best_scores(scores: ArrayLike) -> NDArray[np.float64]:
    """Best score of each row, NaN where nothing was compared."""
    table = np.asarray(scores, dtype=np.float64)
    best = np.where(np.isnan(table), -np.inf, table).max(axis=1)
    return np.where(np.isnan(table).all(axis=1), np.nan, best)
