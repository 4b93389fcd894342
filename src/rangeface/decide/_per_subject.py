"""From a score for each template to a score for each person."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError


def per_subject(scores: ArrayLike, owners: ArrayLike, *, count: int) -> NDArray[np.float32]:
    """Best score of each person over all their templates and views.

    Parameters
    ----------
    scores : (n, rows) or (rows,) array_like
        Scores against every enrolled row; NaN where no comparison could be made.
    owners : (rows,) array_like of int
        Person of each row, 0 … count − 1.
    count : int
        Number of people.

    Returns
    -------
    (n, count) or (count,) float32
        NaN for a person without a comparison.

    Raises
    ------
    ParameterError
        The sizes do not fit, or an owner is out of range.

    Examples
    --------
    >>> per_subject([0.1, 0.7, 0.3], [0, 0, 1], count=2)
    array([0.7, 0.3], dtype=float32)
    """
    table = np.asarray(scores, dtype=np.float32)
    rows = np.asarray(owners, dtype=np.intp)
    if rows.shape != table.shape[-1:]:
        raise ParameterError(f"owners: {rows.shape} does not fit scores {table.shape}")
    if rows.size and (rows.min() < 0 or rows.max() >= count):
        raise ParameterError(f"owners: must be in 0 … {count - 1}")
    best = np.full((*table.shape[:-1], count), np.nan, dtype=np.float32)
    _keep_best(table.reshape(-1, rows.size), rows, best.reshape(-1, count))
    return best


@njit(cache=True, nogil=True)
def _keep_best(table, rows, best):  # type: ignore[no-untyped-def]
    for i in range(table.shape[0]):
        for j in range(rows.size):
            score = table[i, j]
            if not score <= best[i, rows[j]] and not np.isnan(score):
                best[i, rows[j]] = score
