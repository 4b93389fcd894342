"""A source that misbehaves on purpose."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rangeface.errors import ParameterError, SourceError
from rangeface.sources._protocol import Closing, Frame, Source
from rangeface.types import RangeImage


@dataclass(frozen=True)
class Faults:
    """What goes wrong, and how often.

    Parameters
    ----------
    drop, double, reorder, corrupt : float
        Probability for each frame, 0 … 1: it never comes; comes twice; comes after the next
        one; is garbage, blank, or of another size.
    stall_at : sequence of int
        The camera stalls before these frames.
    stall_s : float
        For so long, s.
    break_at : sequence of int
        The camera is unplugged before these frames: `SourceError`.

    Raises
    ------
    ParameterError
        A probability is outside 0 … 1.
    """

    drop: float = 0.0
    double: float = 0.0
    reorder: float = 0.0
    corrupt: float = 0.0
    stall_at: Sequence[int] = ()
    stall_s: float = 5.0
    break_at: Sequence[int] = ()

    def __post_init__(self) -> None:
        for name in ("drop", "double", "reorder", "corrupt"):
            if not 0 <= getattr(self, name) <= 1:
                raise ParameterError(f"{name}: must lie in 0 … 1, got {getattr(self, name)}")


class Faulty(Closing):
    """Injects faults into a source, to test what reads it.

    Parameters
    ----------
    source : Source
        A good one.
    faults : Faults
        What goes wrong.
    seed : int
        Same seed, same faults.
    """

    def __init__(self, source: Source, faults: Faults, *, seed: int = 0) -> None:
        self._source = source
        self._faults = faults
        self._rng = np.random.default_rng(seed)

    @property
    def name(self) -> str:
        """The source's address."""
        return self._source.name

    @property
    def rate_hz(self) -> float:
        """The source's frame rate."""
        return self._source.rate_hz

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def __iter__(self) -> Iterator[Frame]:
        late: Frame | None = None
        for frame in self._source:
            if frame.number in self._faults.break_at:
                raise SourceError(f"{self.name}: unplugged at frame {frame.number}")
            if frame.number in self._faults.stall_at:
                time.sleep(self._faults.stall_s)
            if self._happens(self._faults.drop):
                continue
            if self._happens(self._faults.corrupt):
                frame = replace(frame, image=self._garbage(frame.image))
            if late is None and self._happens(self._faults.reorder):
                late = frame
                continue
            yield frame
            if self._happens(self._faults.double):
                yield frame
            if late is not None:
                yield late
                late = None

    def _happens(self, probability: float) -> bool:
        return bool(self._rng.random() < probability)

    def _garbage(self, image: RangeImage) -> RangeImage:
        """Noise, nothing, or a part of the image."""
        kind = self._rng.integers(3)
        if kind == 0:
            return RangeImage(
                self._rng.uniform(1.0, 5000.0, image.shape).astype(np.float32), image.camera
            )
        if kind == 1:
            return RangeImage(np.full(image.shape, np.float32(np.nan)), image.camera)
        return image.crop(0, 0, image.shape[1] // 2, image.shape[0] // 2)
