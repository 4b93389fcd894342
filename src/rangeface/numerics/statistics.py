"""What a count of errors says: intervals, paired tests, corrections."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import betaincinv, ndtri
from scipy.stats import binom

from rangeface.errors import DegenerateError, ParameterError

Interval = tuple[float, float]


def wilson(successes: int, n: int, *, confidence: float = 0.95) -> Interval:
    r"""Wilson's score interval of a proportion.

    .. math::
        \frac{1}{1 + z^2/n}\left(\hat p + \frac{z^2}{2n}
        \pm z\sqrt{\frac{\hat p(1 - \hat p)}{n} + \frac{z^2}{4n^2}}\right)

    Parameters
    ----------
    successes, n : int
        0 ≤ successes ≤ n, n ≥ 1.
    confidence : float
        0 < confidence < 1.

    Returns
    -------
    low, high : float

    Raises
    ------
    ParameterError
        A count or the confidence is out of range.

    References
    ----------
    E. Wilson, J. Am. Stat. Assoc. 22(158), 1927, doi:10.1080/01621459.1927.10502953.

    Examples
    --------
    The 92 % of the source paper are 55 of 60:

    >>> [round(100 * bound) for bound in wilson(55, 60)]
    [82, 96]
    """
    _check_counts(successes, n, confidence)
    z = float(ndtri(0.5 + confidence / 2))
    p = successes / n
    centre = p + z * z / (2 * n)
    half = z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    scale = 1 + z * z / n
    low = 0.0 if successes == 0 else float((centre - half) / scale)
    high = 1.0 if successes == n else float((centre + half) / scale)
    return low, high


def clopper_pearson(successes: int, n: int, *, confidence: float = 0.95) -> Interval:
    """Clopper and Pearson's exact interval of a proportion; covers at least `confidence`.

    Parameters
    ----------
    successes, n : int
        0 ≤ successes ≤ n, n ≥ 1.
    confidence : float
        0 < confidence < 1.

    Returns
    -------
    low, high : float

    Raises
    ------
    ParameterError
        A count or the confidence is out of range.

    References
    ----------
    C. Clopper, E. Pearson, Biometrika 26(4), 1934, doi:10.1093/biomet/26.4.404.

    Examples
    --------
    >>> [round(bound, 4) for bound in clopper_pearson(0, 10)]
    [0.0, 0.3085]
    """
    _check_counts(successes, n, confidence)
    tail = (1 - confidence) / 2
    low = 0.0 if successes == 0 else float(betaincinv(successes, n - successes + 1, tail))
    high = 1.0 if successes == n else float(betaincinv(successes + 1, n - successes, 1 - tail))
    return low, high


def rule_of_three(n: int) -> float:
    """Upper 95 % bound of a rate of which n independent trials showed no case: 3 / n.

    Parameters
    ----------
    n : int
        Trials, ≥ 1.

    Returns
    -------
    float
        At most 1.

    Raises
    ------
    ParameterError
        n < 1.

    References
    ----------
    J. Hanley, A. Lippman-Hand, JAMA 249(13), 1983, doi:10.1001/jama.1983.03330370053031.

    Examples
    --------
    >>> rule_of_three(300)
    0.01
    """
    if n < 1:
        raise ParameterError(f"n: must be ≥ 1, got {n}")
    return min(1.0, 3.0 / n)


def bootstrap_over_groups(
    statistic: Callable[[NDArray[np.intp]], float],
    groups: ArrayLike,
    *,
    rng: np.random.Generator,
    resamples: int = 1000,
    confidence: float = 0.95,
) -> Interval:
    """Percentile interval of a statistic when whole groups (people) are drawn, not rows.

    Rows of one person are not independent: an interval that draws rows is too narrow.

    Parameters
    ----------
    statistic : callable
        Takes row numbers (with repeats), gives a number.
    groups : (n,) array_like
        Group of each row; at least two groups.
    rng : numpy.random.Generator
        Source of the draws.
    resamples : int
        Number of draws, ≥ 1.
    confidence : float
        0 < confidence < 1.

    Returns
    -------
    low, high : float

    Raises
    ------
    ParameterError
        `resamples` or `confidence` is out of range.
    DegenerateError
        Fewer than two groups.

    References
    ----------
    R. Bolle, N. Ratha, S. Pankanti, CVIU 93(1), 2004, doi:10.1016/j.cviu.2003.08.002
    (the subsets bootstrap).

    Examples
    --------
    >>> hits = np.array([1, 1, 1, 0, 0, 0, 1, 1])
    >>> people = ["a", "a", "b", "b", "c", "c", "d", "d"]
    >>> bootstrap_over_groups(lambda rows: hits[rows].mean(), people, rng=np.random.default_rng(0))
    (0.25, 1.0)
    """
    _check_counts(0, 1, confidence)
    if resamples < 1:
        raise ParameterError(f"resamples: must be ≥ 1, got {resamples}")
    _, labels = np.unique(np.asarray(groups), return_inverse=True)
    order = np.argsort(labels, kind="stable")
    members = np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)
    if len(members) < 2:
        raise DegenerateError("groups: at least two are needed to draw from")
    draws = rng.integers(len(members), size=(resamples, len(members)))
    values = [statistic(np.concatenate([members[k] for k in draw])) for draw in draws]
    tail = (1 - confidence) / 2
    low, high = np.quantile(values, [tail, 1 - tail])
    return float(low), float(high)


def mcnemar(first: ArrayLike, second: ArrayLike) -> float:
    """Exact two-sided p-value of McNemar's test: do two methods err on different probes?

    Parameters
    ----------
    first, second : (n,) array_like of bool
        Whether each method was right on each probe.

    Returns
    -------
    float
        p-value; 1 where the methods never differ.

    Raises
    ------
    ParameterError
        The lengths differ.

    References
    ----------
    Q. McNemar, Psychometrika 12(2), 1947, doi:10.1007/BF02295996.

    Examples
    --------
    Ten probes that only the first method gets right, none the other way round:

    >>> mcnemar([True] * 10 + [True], [False] * 10 + [True])
    0.001953125
    """
    a, b = _paired(first, second, bool)
    only_first = int(np.count_nonzero(a & ~b))
    only_second = int(np.count_nonzero(b & ~a))
    discordant = only_first + only_second
    if discordant == 0:
        return 1.0
    return min(1.0, 2.0 * float(binom.cdf(min(only_first, only_second), discordant, 0.5)))


def permutation_test(
    first: ArrayLike,
    second: ArrayLike,
    *,
    rng: np.random.Generator,
    groups: ArrayLike | None = None,
    resamples: int = 9999,
) -> float:
    """Two-sided p-value of the mean difference of paired values, by flipping signs.

    Parameters
    ----------
    first, second : (n,) array_like of float
        Values of two methods on the same probes.
    rng : numpy.random.Generator
        Source of the flips.
    groups : (n,) array_like, optional
        Person of each row: all rows of one person flip together.
    resamples : int
        Number of flips, ≥ 1; the smallest p-value is 1 / (resamples + 1).

    Returns
    -------
    float
        p-value, never 0: the data themselves count as one of the flips.

    Raises
    ------
    ParameterError
        The lengths differ, or `resamples` is out of range.

    References
    ----------
    B. Phipson, G. Smyth, Stat. Appl. Genet. Mol. Biol. 9(1), 2010, doi:10.2202/1544-6115.1585.

    Examples
    --------
    >>> permutation_test([1, 1, 1, 1], [1, 1, 1, 1], rng=np.random.default_rng(0))
    1.0
    """
    a, b = _paired(first, second, float)
    if resamples < 1:
        raise ParameterError(f"resamples: must be ≥ 1, got {resamples}")
    _, people = np.unique(
        np.arange(len(a)) if groups is None else np.asarray(groups), return_inverse=True
    )
    differences = np.bincount(people, weights=a - b)
    observed = abs(differences.sum())
    flips = rng.integers(2, size=(resamples, len(differences))) * 2 - 1
    rounding = 1e-9 * np.abs(differences).sum()
    extreme = np.count_nonzero(np.abs(flips @ differences) >= observed - rounding)
    return float((extreme + 1) / (resamples + 1))


def holm(p_values: ArrayLike) -> NDArray[np.float64]:
    """p-values corrected for many comparisons, by Holm's step-down method.

    Parameters
    ----------
    p_values : (k,) array_like
        In [0, 1].

    Returns
    -------
    (k,) float64
        Corrected p-values in the same order: reject those below the level.

    Raises
    ------
    ParameterError
        A p-value is outside [0, 1].

    References
    ----------
    S. Holm, Scand. J. Stat. 6(2), 1979.

    Examples
    --------
    >>> holm([0.01, 0.04, 0.03])
    array([0.03, 0.06, 0.06])
    """
    p = np.asarray(p_values, dtype=np.float64)
    if p.ndim != 1 or not ((p >= 0) & (p <= 1)).all():
        raise ParameterError("p_values: must be a list of numbers in [0, 1]")
    order = np.argsort(p, kind="stable")
    stepped = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    corrected = np.empty_like(p)
    corrected[order] = np.minimum(stepped, 1.0)
    return corrected


def _paired(first: ArrayLike, second: ArrayLike, kind: type) -> tuple[NDArray[Any], NDArray[Any]]:
    a: NDArray[Any] = np.asarray(first, dtype=kind)
    b: NDArray[Any] = np.asarray(second, dtype=kind)
    if a.ndim != 1 or a.shape != b.shape:
        raise ParameterError(f"first, second: must be paired, got {a.shape} and {b.shape}")
    return a, b


def _check_counts(successes: int, n: int, confidence: float) -> None:
    if not 0 <= successes <= n or n < 1:
        raise ParameterError(f"successes, n: need 0 ≤ successes ≤ n, n ≥ 1, got {successes} of {n}")
    if not 0 < confidence < 1:
        raise ParameterError(f"confidence: must be in (0, 1), got {confidence}")
