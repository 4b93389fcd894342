"""Each head's scores against what other people reach: the cohort and the gallery together."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError, ParameterError

Array = NDArray[np.float64]

_TO_SIGMA = 1.4826  # median absolute deviation → standard deviation of a normal distribution


def pooled_norm(
    scores: ArrayLike,
    cohort: ArrayLike | None = None,
    *,
    centre_prior: float = 2.0,
    spread_prior: float = 20.0,
) -> Array:
    r"""Each head's scores against what other people reach, cohort and gallery taken together.

    .. math::
        s'_{hj} = \frac{s_{hj} - μ_h}{σ_h}, \quad
        μ_h = \frac{κ_μ m^c_h + n\, m^g_h}{κ_μ + n}, \quad
        σ_h = \frac{κ_σ d^c_h + n\, d^g_h}{κ_σ + n}, \quad n = S - 1

    with the median m and 1.4826 times the median absolute deviation d, over the cohort (c) and
    over the gallery (g).

    Parameters
    ----------
    scores : (H, S) array_like
        One probe against S people by H heads; NaN where a head could not compare.
    cohort : (H, C) array_like, optional
        The same probe against C people who are nobody here. None: the gallery alone.
    centre_prior, spread_prior : float
        κ ≥ 0: the cohort counts as this many people for the centre and for the spread.

    Returns
    -------
    (H, S) float64
        Heads on one scale. NaN stays NaN; a head without any score is all NaN.

    Raises
    ------
    ParameterError
        The sizes do not fit, or a negative prior.
    DegenerateError
        Neither cohort nor gallery has two people: there is nothing to measure against.

    Notes
    -----
    People before another sensor, and simulated ones, are all less like a probe than real
    strangers before its own sensor are: their scores lie lower, and a threshold over them lets
    everybody in. How much they differ among each other carries over better. So the gallery soon
    decides on the centre, and the cohort steadies the spread. The median is blind to the one
    mated score, which would inflate its own scale (compare `t_norm`).

    References
    ----------
    R. Auckenthaler, M. Carey, H. Lloyd-Thomas, Digit. Signal Process. 10(1–3), 2000,
    doi:10.1006/dspr.1999.0360; the scale: A. Jain, K. Nandakumar, A. Ross, Pattern Recognit.
    38(12), 2005, doi:10.1016/j.patcog.2005.01.012.

    Examples
    --------
    >>> pooled_norm([[0.0, 1.0, 2.0, 100.0]]).round(2)
    array([[-1.01, -0.34,  0.34, 66.44]])
    """
    table = _table("scores", scores)
    others = np.empty((len(table), 0)) if cohort is None else _table("cohort", cohort)
    if len(others) != len(table):
        raise ParameterError(f"cohort: {others.shape} does not fit scores {table.shape}")
    for name, prior in (("centre_prior", centre_prior), ("spread_prior", spread_prior)):
        if not (np.isfinite(prior) and prior >= 0):
            raise ParameterError(f"{name}: must be ≥ 0, got {prior}")
    known = ~np.isnan(table).all(axis=1)
    out = np.full(table.shape, np.nan)
    if known.any():
        n = max(table.shape[1] - 1, 0)
        gallery, people = _location(table[known]), _location(others[known])
        centre = _mixed(gallery[0], n, people[0], centre_prior)
        spread = _mixed(gallery[1], n, people[1], spread_prior)
        constant = spread <= 1e-9 * np.maximum(1.0, np.abs(centre))
        out[known] = (table[known] - centre) / np.where(constant, 1.0, spread)
    return out


def _location(values: Array) -> tuple[Array, Array]:
    """Median and spread (H, 1) of each head; NaN where it has fewer than two scores."""
    enough = np.count_nonzero(~np.isnan(values), axis=1) >= 2
    median = np.full((len(values), 1), np.nan)
    spread = median.copy()
    if enough.any():
        median[enough] = np.nanmedian(values[enough], axis=1, keepdims=True)
        deviation = np.abs(values[enough] - median[enough])
        spread[enough] = _TO_SIGMA * np.nanmedian(deviation, axis=1, keepdims=True)
    return median, spread


def _mixed(gallery: Array, n: float, cohort: Array, prior: float) -> Array:
    """Mean of the two by their weights; of the one that is known, whatever its weight."""
    if (np.isnan(gallery) & np.isnan(cohort)).any():
        raise DegenerateError("cohort: to normalise, it or the gallery needs at least two people")
    w_gallery = np.where(np.isnan(gallery), 0.0, np.where(np.isnan(cohort), 1.0, n))
    w_cohort = np.where(np.isnan(cohort), 0.0, np.where(np.isnan(gallery), 1.0, prior))
    total = w_gallery * np.nan_to_num(gallery) + w_cohort * np.nan_to_num(cohort)
    return np.asarray(total / (w_gallery + w_cohort))


def no_norm(scores: ArrayLike, cohort: ArrayLike | None = None) -> Array:
    """Scores as they are; the cohort is not asked.

    Parameters
    ----------
    scores : (H, S) array_like
        One probe against S people by H heads.
    cohort : (H, C) array_like, optional
        Ignored.

    Returns
    -------
    (H, S) float64

    Raises
    ------
    ParameterError
        Not a table.

    Examples
    --------
    >>> no_norm([[0.5, 2.0]])
    array([[0.5, 2. ]])
    """
    return _table("scores", scores)


def _table(name: str, scores: ArrayLike) -> Array:
    table = np.asarray(scores, dtype=np.float64)
    if table.ndim != 2:
        raise ParameterError(f"{name}: expected a table (heads, people), got {table.shape}")
    return table
