"""Fusion of several matchers' scores by a weighted sum."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError


def weighted_sum(scores: ArrayLike, *, weights: ArrayLike | None = None) -> NDArray[np.float64]:
    r"""Weighted mean of the matchers' scores over those that have one.

    .. math:: s = \sum_h w_h s_h \Big/ \sum_h w_h \quad \text{over the heads } h
        \text{ whose score is not missing}

    Parameters
    ----------
    scores : (H, …) array_like
        Scores of H matchers on one scale (normalise them first), mostly (H, n, m); NaN where a
        matcher had none.
    weights : array_like, optional
        ≥ 0: (H,) one a matcher, (H, n) one a matcher and probe (its quality, or 1/σ² of its
        noise), or any shape that fits the front of `scores`. None: equal (the sum rule).

    Returns
    -------
    (…) float64
        NaN where no matcher of positive weight had a score.

    Raises
    ------
    ParameterError
        A weight is negative or not finite, or the shapes do not fit.

    References
    ----------
    J. Kittler et al., IEEE TPAMI 20(3), 1998, doi:10.1109/34.667881 (the sum rule).

    Examples
    --------
    >>> weighted_sum([[1.0, 4.0], [3.0, np.nan]], weights=[3.0, 1.0])
    array([1.5, 4. ])
    """
    table = np.asarray(scores, dtype=np.float64)
    w = np.ones(len(table)) if weights is None else np.asarray(weights, dtype=np.float64)
    if not (np.isfinite(w) & (w >= 0)).all():
        raise ParameterError("weights: must be finite and ≥ 0")
    if w.ndim == 0 or w.shape != table.shape[: w.ndim]:
        raise ParameterError(f"weights: {w.shape} does not fit scores {table.shape}")
    w = np.where(np.isnan(table), 0.0, w.reshape(w.shape + (1,) * (table.ndim - w.ndim)))
    total = w.sum(axis=0)
    fused = (w * np.nan_to_num(table)).sum(axis=0)
    return np.divide(fused, total, out=np.full(total.shape, np.nan), where=total > 0)
