"""Run a protocol: enrol the gallery, compare every probe, rate the scores."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from rangeface.decide import t_norm
from rangeface.errors import DegenerateError, NoFaceError, ScanError
from rangeface.evaluation.error_rates import (
    Rate,
    eer,
    failure_to_acquire,
    fnmr_at_fmr,
    mated_nonmated,
    rank_k,
)
from rangeface.gallery import stack
from rangeface.numerics.statistics import rule_of_three
from rangeface.pipeline import FacePipeline, Trace
from rangeface.types import Float64, RangeImage, Scan


@dataclass(frozen=True, eq=False)
class Capture:
    """A scan and how far it came: its trace, or the error that its file gave.

    Parameters
    ----------
    scan : Scan
    trace : Trace, optional
        None if the file could not be read.
    failure : str
        Why there is no frontal image; "" if there is one.
    """

    scan: Scan
    trace: Trace | None
    failure: str = ""

    @property
    def acquired(self) -> bool:
        """Whether it reached the frontal grid."""
        return self.trace is not None and self.trace.frontal is not None


#: Capture → its frontal image and the rotated ones.
Views: TypeAlias = dict[Capture, list[RangeImage]]


@dataclass(frozen=True, eq=False)
class Scores:
    """Every probe against every enrolled person.

    Parameters
    ----------
    table : (n, m) float64
        Higher = more alike; a row of NaN is a probe that failed to acquire.
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

    table: Float64
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
        return replace(self, table=self.table[chosen], probes=tuple(self.probes[i] for i in chosen))


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
        Equal error rate of the scores normalised per probe over the gallery, and of raw ones.
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


def acquire(pipeline: FacePipeline, scans: Iterable[Scan]) -> list[Capture]:
    """Load and trace every scan; what fails is counted, and the run goes on.

    Parameters
    ----------
    pipeline : FacePipeline
        Fitted or not: only what stands before the heads matters.
    scans : iterable of Scan

    Returns
    -------
    list of Capture
        One a scan, in order.
    """
    captures = []
    for scan in scans:
        try:
            trace = pipeline.trace(scan.load())
            captures.append(Capture(scan, trace, trace.reason.value if trace.reason else ""))
        except ScanError as error:
            captures.append(Capture(scan, None, f"{error.fault}: {error.detail}"))
    return captures


def compare(
    pipeline: FacePipeline,
    captures: Sequence[Capture],
    *,
    training: Sequence[Capture] | None = None,
    views: Views | None = None,
) -> Scores:
    """Fit on the training captures, enrol the gallery, and score every probe.

    Parameters
    ----------
    pipeline : FacePipeline
        Fitted again here.
    captures : sequence of Capture
        Roles "gallery" and "probe" (and "train").
    training : sequence of Capture, optional
        Default: those of role "train"; if there is none, the gallery itself.
    views : dict, optional
        Frontal views that a run with other heads has already made; filled here.

    Returns
    -------
    Scores

    Raises
    ------
    NoFaceError
        No training capture or no gallery capture shows a face.
    DegenerateError
        There is no gallery or no probe.
    """
    gallery = [c for c in captures if c.scan.role == "gallery"]
    probes = tuple(c for c in captures if c.scan.role == "probe")
    if not gallery or not probes:
        raise DegenerateError(
            f"{len(gallery)} gallery scans and {len(probes)} probes: both are needed"
        )
    if training is None:
        training = [c for c in captures if c.scan.role == "train"] or gallery
    usable = [c for c in training if c.acquired]
    enrolled = [c for c in gallery if c.acquired]
    if not usable or not enrolled:
        raise NoFaceError(
            f"no face in any of {len(gallery)} gallery and {len(training)} training scans"
        )
    views = {} if views is None else views
    for capture in (*usable, *enrolled):
        if capture not in views:
            views[capture] = pipeline.views(_trace(capture))
    fitted = pipeline.fit_views([views[c] for c in usable], [c.scan.subject for c in usable])
    references = stack(
        ((c.scan.subject, fitted.template_of(views[c])) for c in enrolled), fitted.fingerprint
    )
    people = tuple(sorted({c.scan.subject for c in gallery}))
    column = [people.index(subject) for subject in references.subjects]
    table = np.full((len(probes), len(people)), np.nan)
    times = []
    for row, capture in zip(table, probes, strict=True):
        if capture.acquired:
            start = time.perf_counter()
            row[column] = fitted.similarity(fitted.template(_trace(capture)), references)
            times.append(1e3 * (time.perf_counter() - start))
    return Scores(
        table, probes, people, len(references.subjects), fitted.fingerprint,
        float(np.median(times)) if times else float("nan"),
    )  # fmt: skip


def _trace(capture: Capture) -> Trace:
    assert capture.trace is not None
    return capture.trace


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
        eer_raw=eer(*mated_nonmated(table, subjects, people)),
        fta=failure_to_acquire(table),
        fmr=fmr,
        fnmr=fnmr_at_fmr(mated, nonmated, fmr),
    )


def stage_times(captures: Sequence[Capture], match_ms: float) -> dict[str, float]:
    """Median milliseconds of each stage over all captures that reached it.

    Parameters
    ----------
    captures : sequence of Capture
    match_ms : float
        Time from features to scores.

    Returns
    -------
    dict of str to float
    """
    times: dict[str, list[float]] = {}
    for capture in captures:
        for stage, ms in (capture.trace.times_ms if capture.trace else {}).items():
            times.setdefault(stage, []).append(ms)
    medians = {stage: round(float(np.median(values)), 3) for stage, values in times.items()}
    return {**medians, "match": round(match_ms, 3)}
