"""Scans, templates and decisions: who was captured, stored, recognised."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from rangeface.types._arrays import Float32, Float64, frozen
from rangeface.types._faces import Assessment, Reason
from rangeface.types._images import RangeImage

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True, eq=False)
class Scan:
    """One capture of a database: who, when, how, and how to load it.

    Parameters
    ----------
    path : Path
        The file, or the folder of a sequence.
    loader : callable
        Reads `path`: one image, or the frames of a sequence; raises ScanError.
    subject : str
        Who it shows.
    role : str
        "train", "gallery", "probe" or "" (the protocol decides).
    session, view, expression, sensor : str
        As the database says; "" where it does not.
    landmarks : mapping of str to (3,) array
        Landmarks that the database gives, camera frame, mm.
    """

    path: Path
    loader: Callable[[Path], RangeImage | list[RangeImage]] = field(repr=False)
    subject: str = ""
    role: str = ""
    session: str = ""
    view: str = ""
    expression: str = ""
    sensor: str = ""
    landmarks: Mapping[str, Float64] = field(default_factory=dict)

    def load(self) -> RangeImage | list[RangeImage]:
        """Read the capture: one image, or the frames of a sequence.

        Raises
        ------
        ScanError
            The file is missing or broken; the message names it.
        """
        return self.loader(self.path)


@dataclass(frozen=True, eq=False)
class Template:
    """What is stored of a face: per head, one row for every view of it.

    Parameters
    ----------
    vectors : tuple of (k, D) arrays
        One array a head of the pipeline, in its order.
    fingerprint : str
        Of the fitted pipeline that made it; templates of others do not compare.
    assessment : Assessment, optional
        Quality of the capture.
    """

    vectors: tuple[Float32, ...]
    fingerprint: str
    assessment: Assessment | None = None

    def __post_init__(self) -> None:
        vectors = tuple(frozen(v, np.float32, "vectors", None) for v in self.vectors)
        object.__setattr__(self, "vectors", vectors)


class Verdict(StrEnum):
    """The three answers that a decision can give."""

    ACCEPTED = "accepted"
    UNKNOWN = "unknown"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class Decision:
    """The answer to "who is this?" or "is this X?".

    Parameters
    ----------
    verdict : Verdict
        Accepted, unknown, or cannot tell.
    subject : str, optional
        Who was recognised; None unless accepted.
    score : float
        Best score; NaN where nothing could be compared.
    threshold : float
        The score that was needed.
    reason : Reason, optional
        Why it was not accepted.
    ranking : tuple of (str, float)
        The best subjects and their scores, best first.
    """

    verdict: Verdict
    subject: str | None = None
    score: float = float("nan")
    threshold: float = float("nan")
    reason: Reason | None = None
    ranking: tuple[tuple[str, float], ...] = ()
