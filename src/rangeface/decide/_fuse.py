"""Scores of several heads → one score."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rangeface.types import Float32


def sum_rule(scores: ArrayLike) -> Float32:
    """Mean of the heads' scores; a head without a score is left out.

    Parameters
    ----------
    scores : (h, m) array_like
        One row a head, on comparable scales; NaN where a head could not compare.

    Returns
    -------
    (m,) float32
        NaN where no head has a score.

    Examples
    --------
    >>> sum_rule([[1.0, 2.0], [3.0, float("nan")]])
    array([2., 2.], dtype=float32)
    """
    table = np.atleast_2d(np.asarray(scores, dtype=np.float32))
    known = np.isfinite(table)
    count = known.sum(axis=0)
    total = np.where(known, table, np.float32(0.0)).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.float32(np.nan))
