"""Score normalisations: the same number means the same for every probe and every template.

All take scores (n probes, m enrolled), NaN where no comparison was made, and give the same
shape. A constant row or column has no scale; it is only centred.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError, ParameterError

Array = NDArray[np.float64]


def z_norm(scores: ArrayLike, cohort: ArrayLike) -> Array:
    r"""Zero normalisation: each enrolled template against probes of other people.

    .. math:: s' = (s - μ_j) / σ_j \quad \text{over the cohort's scores with template } j

    Parameters
    ----------
    scores : (n, m) array_like
        Scores.
    cohort : (c, m) array_like
        Scores of c cohort probes, none of an enrolled person, against the same templates.

    Returns
    -------
    (n, m) float64

    Raises
    ------
    ParameterError
        The sizes do not fit.
    DegenerateError
        A template has fewer than two cohort scores.

    References
    ----------
    R. Auckenthaler, M. Carey, H. Lloyd-Thomas, Digit. Signal Process. 10(1–3), 2000,
    doi:10.1006/dspr.1999.0360.

    Examples
    --------
    >>> z_norm([[4.0]], [[1.0], [3.0]])
    array([[2.]])
    """
    table = _table("scores", scores)
    others = _table("cohort", cohort)
    if others.shape[1] != table.shape[1]:
        raise ParameterError(f"cohort: {others.shape} does not fit scores {table.shape}")
    return _standardise(table.T, others.T).T


def t_norm(scores: ArrayLike, cohort: ArrayLike | None = None) -> Array:
    r"""Test normalisation: each probe against templates of other people.

    .. math:: s' = (s - μ_i) / σ_i \quad \text{over the cohort's scores with probe } i

    Parameters
    ----------
    scores : (n, m) array_like
        Scores.
    cohort : (n, c) array_like, optional
        Scores of the same probes against c cohort templates. None: the gallery itself, "each
        probe z-normalised over the gallery".

    Returns
    -------
    (n, m) float64

    Raises
    ------
    ParameterError
        The sizes do not fit.
    DegenerateError
        A probe with scores has fewer than two cohort scores.

    References
    ----------
    As `z_norm`.

    Examples
    --------
    >>> t_norm([[1.0, 3.0]])
    array([[-1.,  1.]])
    """
    table = _table("scores", scores)
    others = table if cohort is None else _table("cohort", cohort)
    if len(others) != len(table):
        raise ParameterError(f"cohort: {others.shape} does not fit scores {table.shape}")
    return _standardise(table, others)


def s_norm(scores: ArrayLike, probe_cohort: ArrayLike, template_cohort: ArrayLike) -> Array:
    """Symmetric normalisation: the mean of `t_norm` and `z_norm`.

    Parameters
    ----------
    scores : (n, m) array_like
        Scores.
    probe_cohort : (n, c) array_like
        Scores of the probes against c cohort templates.
    template_cohort : (c, m) array_like
        Scores of c cohort probes against the templates.

    Returns
    -------
    (n, m) float64

    Raises
    ------
    ParameterError
        The sizes do not fit.
    DegenerateError
        A row or column has fewer than two cohort scores.

    References
    ----------
    P. Kenny, Odyssey 2010 (Bayesian speaker verification with heavy-tailed priors).

    Examples
    --------
    >>> s_norm([[4.0]], [[1.0, 3.0]], [[1.0], [3.0]])
    array([[2.]])
    """
    return np.asarray(0.5 * (t_norm(scores, probe_cohort) + z_norm(scores, template_cohort)))


def robust_norm(scores: ArrayLike) -> Array:
    r"""Each probe over the gallery by median and median absolute deviation.

    .. math:: s' = (s - \mathrm{med}_i) / (1.4826\,\mathrm{MAD}_i)

    The one mated score among m does not inflate its own scale, as it does in `t_norm`.

    Parameters
    ----------
    scores : (n, m) array_like
        Scores.

    Returns
    -------
    (n, m) float64

    Raises
    ------
    ParameterError
        Not a table.
    DegenerateError
        A probe with scores has fewer than two.

    References
    ----------
    A. Jain, K. Nandakumar, A. Ross, Pattern Recognit. 38(12), 2005,
    doi:10.1016/j.patcog.2005.01.012.

    Examples
    --------
    >>> robust_norm([[0.0, 1.0, 2.0, 100.0]]).round(2)
    array([[-1.01, -0.34,  0.34, 66.44]])
    """
    table = _table("scores", scores)
    used = _comparable(table, table)
    median = np.nanmedian(table[used], axis=1, keepdims=True)
    mad = 1.4826 * np.nanmedian(np.abs(table[used] - median), axis=1, keepdims=True)
    out = np.full(table.shape, np.nan)
    out[used] = (table[used] - median) / np.where(mad > 0, mad, 1.0)
    return out


def _standardise(table: Array, cohort: Array) -> Array:
    used = _comparable(table, cohort)
    mean = np.nanmean(cohort[used], axis=1, keepdims=True)
    deviation = np.nanstd(cohort[used], axis=1, keepdims=True)
    constant = deviation <= 1e-12 * np.maximum(1.0, np.abs(mean))
    out = np.full(table.shape, np.nan)
    out[used] = (table[used] - mean) / np.where(constant, 1.0, deviation)
    return out


def _comparable(table: Array, cohort: Array) -> NDArray[np.bool_]:
    used = np.asarray(~np.isnan(table).all(axis=1))
    if (np.count_nonzero(~np.isnan(cohort[used]), axis=1) < 2).any():
        raise DegenerateError("cohort: a normalisation needs at least two scores")
    return used


def _table(name: str, scores: ArrayLike) -> Array:
    table = np.asarray(scores, dtype=np.float64)
    if table.ndim != 2:
        raise ParameterError(f"{name}: expected a table (n, m), got {table.shape}")
    return table
