"""Scores of several heads → one score."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from rangeface.errors import ParameterError
from rangeface.types import Float32, Float64


def sum_rule(scores: ArrayLike) -> Float32:
    """Mean of the heads' scores; a head without a score is left out.

    Parameters
    ----------
    scores : (H, …) array_like
        One row a head, on comparable scales; NaN where a head could not compare.

    Returns
    -------
    (…) float32
        NaN where no head has a score.

    References
    ----------
    J. Kittler et al., IEEE TPAMI 20(3), 1998, doi:10.1109/34.667881.

    Examples
    --------
    >>> sum_rule([[1.0, 2.0], [3.0, float("nan")]])
    array([2., 2.], dtype=float32)
    """
    table = np.atleast_2d(np.asarray(scores, dtype=np.float64))
    return weighted_sum(table, weights=np.ones(len(table)))


def weighted_sum(scores: ArrayLike, *, weights: ArrayLike) -> Float32:
    r"""Weighted mean of the heads' scores over those that have one.

    .. math:: s = \sum_h w_h s_h \Big/ \sum_h w_h \quad \text{over the heads } h
        \text{ whose score is not missing}

    Parameters
    ----------
    scores : (H, …) array_like
        Scores of H heads on comparable scales, mostly (H, m) or (H, n, m); NaN where a head
        could not compare.
    weights : array_like
        ≥ 0: (H,) one a head, (H, n) one a head and probe (its quality, or 1/σ² of its noise),
        or any shape that fits the front of `scores`.

    Returns
    -------
    (…) float32
        NaN where no head of positive weight has a score.

    Raises
    ------
    ParameterError
        A weight is negative or not finite, or the shapes do not fit.

    Examples
    --------
    >>> weighted_sum([[1.0, 4.0], [3.0, np.nan]], weights=(3.0, 1.0))
    array([1.5, 4. ], dtype=float32)
    """
    table = np.asarray(scores, dtype=np.float64)
    w = np.asarray(weights, dtype=np.float64)
    if not (np.isfinite(w) & (w >= 0)).all():
        raise ParameterError("weights: must be finite and ≥ 0")
    if w.ndim == 0 or w.shape != table.shape[: w.ndim]:
        raise ParameterError(f"weights: {w.shape} does not fit scores {table.shape}")
    w = np.where(np.isnan(table), 0.0, w.reshape(w.shape + (1,) * (table.ndim - w.ndim)))
    total = w.sum(axis=0)
    fused = (w * np.nan_to_num(table)).sum(axis=0)
    mean = np.divide(fused, total, out=np.full(total.shape, np.nan), where=total > 0)
    return np.asarray(mean, dtype=np.float32)


def linear_llr(
    scores: ArrayLike,
    *,
    weights: Sequence[float],
    centres: Sequence[float],
    scales: Sequence[float],
    bias: float,
) -> Float64:
    r"""Log-likelihood ratio of the heads' scores, with parameters that `LlrFusion` fitted.

    .. math:: \mathrm{LLR}(s) = b + \sum_h w_h \frac{s_h - c_h}{σ_h}

    Parameters
    ----------
    scores : (H, …) array_like
        Scores of H heads; NaN where a head could not compare: no evidence.
    weights, centres, scales : (H,) sequence of float
        w, c and σ > 0.
    bias : float
        b.

    Returns
    -------
    (…) float64
        Natural logarithm; NaN where no head has a score.

    Raises
    ------
    ParameterError
        A parameter is not finite, a scale is not positive, or the lengths differ.

    Examples
    --------
    >>> linear_llr([[1.0], [9.0]], weights=(2, 1), centres=(0, 5), scales=(1, 4), bias=-1)
    array([2.])
    """
    table = np.asarray(scores, dtype=np.float64)
    w, c, s = (np.asarray(p, dtype=np.float64) for p in (weights, centres, scales))
    if not w.shape == c.shape == s.shape == (len(table),):
        raise ParameterError(f"weights, centres, scales: need one for each of {len(table)} heads")
    if not (np.isfinite([*w, *c, *s, bias]).all() and (s > 0).all()):
        raise ParameterError("weights, centres, scales, bias: must be finite, scales > 0")
    column = (slice(None),) + (None,) * (table.ndim - 1)
    evidence = np.nan_to_num((table - c[column]) / s[column])
    llr = bias + np.tensordot(w, evidence, axes=1)
    return np.where(np.isnan(table).all(axis=0), np.nan, llr)
