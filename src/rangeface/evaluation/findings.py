"""What an experiment found: tables, and verdicts on what somebody claimed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.evaluation.comparisons import Comparisons
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.grid import Cell
from rangeface.numerics.statistics import bootstrap_over_groups, holm, permutation_test

#: p-values below this decide, after correction for all claims of a source in an experiment.
LEVEL = 0.05

HOLDS, FAILS, UNDECIDED = "holds", "does not hold", "cannot tell"


@dataclass(frozen=True)
class Entry:
    """A rate of ours, beside the rate that the paper prints.

    Parameters
    ----------
    rate : Rate
    paper : float, optional
        Percent, as printed.
    """

    rate: Rate
    paper: float | None = None

    def __str__(self) -> str:
        r = self.rate
        ours = f"{100 * r.rate:.0f} [{100 * r.low:.0f}, {100 * r.high:.0f}]"
        return ours if self.paper is None else f"{ours} ({self.paper:g})"

    def _repr_html_(self) -> str:
        r = self.rate
        paper = "" if self.paper is None else f"&nbsp;<i>({self.paper:g})</i>"
        return (
            f"<b>{100 * r.rate:.0f}</b>{paper}<br>"
            f"<small>{100 * r.low:.0f}–{100 * r.high:.0f}</small>"
        )


@dataclass(frozen=True)
class Table:
    """A table of entries and words.

    Parameters
    ----------
    name : str
        Short: it names files.
    caption : str
        What it shows, with units.
    header : sequence of str
        Column names.
    rows : sequence of sequences
        `Entry`, numbers or words.
    """

    name: str
    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[Any]]


@dataclass(frozen=True, eq=False)
class Claim:
    """Somebody says that one thing is better than another, or as good.

    Parameters
    ----------
    text : str
        The claim, in words.
    source : str
        Who says so: a table or a page.
    first, second : (n,) array_like
        Paired values, hits as 0 or 1: the claim is mean(first) > mean(second).
    people : (n,) array_like
        Person of each row: the rows of a person are not independent.
    margin : float, optional
        The claim is "no worse than by this much, and no better" instead, 0 … 1.
    """

    text: str
    source: str
    first: ArrayLike
    second: ArrayLike
    people: ArrayLike
    margin: float | None = None


@dataclass(frozen=True)
class Verdict:
    """What the data say of a claim.

    Parameters
    ----------
    text, source : str
        Of the claim.
    difference, low, high : float
        Mean difference and its 95 % interval (bootstrap over people), −1 … 1.
    p : float
        Corrected by Holm's method over all claims of the same source in the experiment.
    verdict : str
        "holds", "does not hold" or "cannot tell".
    """

    text: str
    source: str
    difference: float
    low: float
    high: float
    p: float
    verdict: str


@dataclass
class Findings:
    """Everything that a report of an experiment shows.

    Parameters
    ----------
    title, question : str
    readings : list of str
        Our readings where the paper is silent, and what limits the result.
    tables : list of Table
    verdicts : list of Verdict
    figures : list of (caption, PNG bytes)
    shown : (str, Cell), optional
        The condition whose scores the report shows, for one of the experiments.
    comparisons : (str, Comparisons), optional
        The scores themselves, with a name: drawn, rated and written as a score file.
    """

    title: str
    question: str
    readings: list[str] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    verdicts: list[Verdict] = field(default_factory=list)
    figures: list[tuple[str, bytes]] = field(default_factory=list)
    shown: tuple[str, Cell] | None = None
    comparisons: tuple[str, Comparisons] | None = None


def judge(claims: Sequence[Claim]) -> list[Verdict]:
    """Test claims on paired data, corrected for their number.

    Parameters
    ----------
    claims : sequence of Claim
        All that an experiment tests: those of one source together are a family.

    Returns
    -------
    list of Verdict
        An ordering holds if the corrected p-value of a permutation test over people is below
        0.05 and the difference has the claimed sign, and does not hold if it has the other sign.
        "As good" holds if both one-sided tests reject a difference beyond the margin, and does
        not hold if the whole 95 % interval lies outside it.

    Raises
    ------
    ParameterError
        First, second and people of a claim differ in length.

    References
    ----------
    D. Schuirmann, J. Pharmacokinet. Biopharm. 15, 1987, doi:10.1007/BF01068419 (the two
    one-sided tests).

    Examples
    --------
    >>> claim = Claim("a > b", "me", [1] * 12, [0] * 12, range(12))
    >>> judge([claim])[0].verdict
    'holds'
    """
    if not claims:
        return []
    for claim in claims:
        sizes = {len(np.asarray(x)) for x in (claim.first, claim.second, claim.people)}
        if len(sizes) != 1:
            raise ParameterError(f"claim {claim.text!r}: first, second, people must be paired")
    p_values = np.array([_p_value(claim) for claim in claims])
    sources = np.array([claim.source for claim in claims])
    for source in set(sources.tolist()):
        p_values[sources == source] = holm(p_values[sources == source])
    return [_verdict(claim, float(p)) for claim, p in zip(claims, p_values, strict=True)]


def _difference(claim: Claim) -> NDArray[np.float64]:
    return np.asarray(claim.first, np.float64) - np.asarray(claim.second, np.float64)


def _p_value(claim: Claim) -> float:
    d = _difference(claim)
    if claim.margin is None:
        return _permuted(d, claim)
    # equivalence: the larger p of the two one-sided tests, each half of a two-sided one
    sides = [(d + claim.margin, 1), (d - claim.margin, -1)]
    ps = [_permuted(x, claim) / 2 for x, sign in sides if sign * x.mean() > 0]
    return max(ps) if len(ps) == 2 else 1.0


def _permuted(d: NDArray[np.float64], claim: Claim) -> float:
    rng = np.random.default_rng(0)
    return permutation_test(d, np.zeros(len(d)), groups=claim.people, rng=rng)


def _verdict(claim: Claim, p: float) -> Verdict:
    d = _difference(claim)

    def mean(rows: NDArray[np.intp]) -> float:
        return float(d[rows].mean())

    low, high = bootstrap_over_groups(mean, claim.people, rng=np.random.default_rng(0))
    answer = HOLDS if p < LEVEL else UNDECIDED
    if claim.margin is None:
        answer = FAILS if p < LEVEL and d.mean() < 0 else answer
    elif low > claim.margin or high < -claim.margin:
        answer = FAILS
    return Verdict(claim.text, claim.source, float(d.mean()), low, high, p, answer)
