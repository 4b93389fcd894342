"""Every intermediate of one image's way."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from rangeface.types import Alignment, Assessment, Face, Faces, Float32, RangeImage, Reason


@dataclass(frozen=True, eq=False)
class Trace:
    """Every intermediate of one image's way, and what each stage took.

    Parameters
    ----------
    image : RangeImage
        The (combined) image.
    denoised : RangeImage
        After denoising.
    faces : Faces
        All faces found, most confident first.
    face : Face, optional
        The one that is followed.
    alignment, frontal, assessment
        Of that face; None where the way ended before.
    features : tuple of arrays
        One a head.
    reason : Reason, optional
        Why the way ended.
    times_ms : mapping of str to float
        Stage → milliseconds.
    """

    image: RangeImage
    denoised: RangeImage
    faces: Faces
    face: Face | None = None
    alignment: Alignment | None = None
    frontal: RangeImage | None = None
    assessment: Assessment | None = None
    features: tuple[Float32, ...] = ()
    reason: Reason | None = None
    times_ms: dict[str, float] = field(default_factory=dict)


@contextmanager
def timed(times_ms: dict[str, float], stage: str) -> Iterator[None]:
    """Write the milliseconds of the block under the stage's name."""
    start = time.perf_counter()
    yield
    times_ms[stage] = 1e3 * (time.perf_counter() - start)
