"""What every source gives: frames, one after the other, until it ends or breaks."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol, Self

from rangeface.types import RangeImage, RigidTransform


@dataclass(frozen=True, eq=False)
class Seen:
    """Who stands where: the truth that only a synthetic camera knows.

    Parameters
    ----------
    person : int
        Number of the head.
    pose : RigidTransform
        T_camera_face.
    """

    person: int
    pose: RigidTransform


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame of a source.

    Parameters
    ----------
    image : RangeImage
        Depth, with σ and amplitude where the source knows them.
    time_s : float
        When it was captured, s since the source's first frame, by the camera's clock.
    number : int
        Counts the frames that the camera made, from 0; gaps are frames that never came.
    arrived_s : float
        When it arrived here, s, by `time.monotonic`.
    dropped : int
        Frames that this computer has thrown away since the start, because newer ones had come.
    truth : tuple of Seen
        Of a synthetic camera; else empty.
    """

    image: RangeImage
    time_s: float
    number: int
    arrived_s: float = field(default_factory=time.monotonic)
    dropped: int = 0
    truth: tuple[Seen, ...] = ()


class Source(Protocol):
    """A camera, a recording, or something that behaves like one.

    Iterating gives frames in the order of their capture, ends where a recording ends, and raises
    `SourceError` or `ScanError` where the source breaks. A source is iterated once.
    """

    @property
    def name(self) -> str:
        """Its address."""

    @property
    def rate_hz(self) -> float:
        """Frames a second that it means to give."""

    def __iter__(self) -> Iterator[Frame]: ...

    def close(self) -> None:
        """Let go of the device or file; from any thread, and more than once."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *failure: object) -> None: ...


class Closing:
    """A source that closes at the end of its `with` block."""

    def close(self) -> None:
        """Nothing to let go of."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()
