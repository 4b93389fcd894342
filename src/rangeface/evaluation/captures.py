"""Scans on their way to a template: what was acquired, what failed and why."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from rangeface.errors import ScanError
from rangeface.pipeline import FacePipeline, Trace
from rangeface.types import RangeImage, Scan


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


def learners(scans: Sequence[Scan]) -> list[Scan]:
    """The scans that a pipeline learns from: of role "train", or the gallery where there are none.

    Parameters
    ----------
    scans : sequence of Scan

    Returns
    -------
    list of Scan
    """
    training = [scan for scan in scans if scan.role == "train"]
    return training or [scan for scan in scans if scan.role == "gallery"]


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
