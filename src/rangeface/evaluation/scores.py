"""Every probe against every enrolled person, and the rates of such a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rangeface.decide import t_norm
from rangeface.errors import DegenerateError
from rangeface.evaluation.captures import Capture
from rangeface.evaluation.error_rates import (
    Rate,
    eer,
    failure_to_acquire,
    fnmr_at_fmr,
    mated_nonmated,
    rank_k,
)
from rangeface.numerics.statistics import rule_of_three
from rangeface.types import Float64


@dataclass(frozen=True, eq=False)
class Scores:
    """Every probe against every enrolled person.

    Parameters
    ----------
    heads : (H, n, m) float64
        Every head normalised as the pipeline does it; higher = more alike; NaN where it could
        not compare. A probe that failed to acquire is NaN throughout.
    fixed : (H, n, m) float64
        Every head on one fixed scale.
    table : (n, m) float64
        `heads` fused, as the pipeline does it.
    raw : (n, m) float64
        `fixed` fused, so that a score depends on its two faces only (1:1).
    probes : tuple of Capture
    people : tuple of str
        Columns.
    enrolled : int
        People with a template; the others' columns are NaN.
    fingerprint : str
        Of the fitted pipeline.
    match_ms : float
        Median time from features to scores of one probe.
    """

    heads: Float64
    fixed: Float64
    table: Float64
    raw: Float64
    probes: tuple[Capture, ...]
    people: tuple[str, ...]
    enrolled: int
    fingerprint: str
    match_ms: float

    @property
    def probe_subjects(self) -> tuple[str, ...]:
        """Who each row shows."""
        return tuple(capture.scan.subject for capture in self.probes)

    def rows(self, keep: Sequence[bool] | np.ndarray) -> Scores:
        """The same scores, of some of the probes."""
        chosen = np.flatnonzero(np.asarray(keep, dtype=bool))
        return replace(
            self,
            heads=self.heads[:, chosen],
            fixed=self.fixed[:, chosen],
            table=self.table[chosen],
            raw=self.raw[chosen],
            probes=tuple(self.probes[i] for i in chosen),
        )


@dataclass(frozen=True)
class Rates:
    """The rates of one set of probes.

    Parameters
    ----------
    n : int
        Number of probes.
    rank1, rank5 : Rate
        Closed-set identification; a failure to acquire is a miss.
    eer, eer_raw : Rate
        Equal error rate of the scores z-normalised per probe over the gallery, and of raw 1:1
        ones.
    fta : Rate
        Failures to acquire.
    fmr : float
        False match rate that `fnmr` belongs to.
    fnmr : Rate
        False non-match rate at that false match rate, of the normalised scores.
    """

    n: int
    rank1: Rate
    rank5: Rate
    eer: Rate
    eer_raw: Rate
    fta: Rate
    fmr: float
    fnmr: Rate

    def to_json(self) -> dict[str, Any]:
        """Plain numbers, rates in 0 … 1."""
        out: dict[str, Any] = {"n": self.n}
        for name in ("rank1", "rank5", "eer", "eer_raw"):
            rate: Rate = getattr(self, name)
            out[name] = {"rate": rate.rate, "low": rate.low, "high": rate.high}
        fnmr = {"rate": self.fnmr.rate, "low": self.fnmr.low, "high": self.fnmr.high}
        out["fnmr_at_fmr"] = {"fmr": self.fmr, **fnmr}
        out["fta"] = self.fta.rate
        return out


def rates(scores: Scores, *, fmr: float | None = None) -> Rates:
    """Rate a table of scores.

    Parameters
    ----------
    scores : Scores
        At least one probe; people who failed to enrol count against their probes.
    fmr : float, optional
        False match rate at which the false non-match rate is given, at least
        3 / number of different-person comparisons. Default: 1 %, or that bound where it is larger.

    Returns
    -------
    Rates

    Raises
    ------
    DegenerateError
        There is no probe.
    ParameterError
        So few comparisons cannot show this `fmr`.
    """
    table, subjects, people = scores.table, scores.probe_subjects, scores.people
    if len(table) == 0:
        raise DegenerateError("no probe to rate")
    normalised = t_norm(table) if scores.enrolled > 1 else table
    mated, nonmated = mated_nonmated(normalised, subjects, people)
    if fmr is None:
        fmr = min(max(0.01, rule_of_three(int(np.count_nonzero(~np.isnan(nonmated))))), 0.99)
    return Rates(
        n=len(table),
        rank1=rank_k(table, subjects, people, k=1),
        rank5=rank_k(table, subjects, people, k=5),
        eer=eer(mated, nonmated),
        eer_raw=eer(*mated_nonmated(scores.raw, subjects, people)),
        fta=failure_to_acquire(table),
        fmr=fmr,
        fnmr=fnmr_at_fmr(mated, nonmated, fmr),
    )
