"""The faces close up: what the page turns, and what an enrolment is made from."""

from __future__ import annotations

import time

import numpy as np

from rangeface.live import LiveRecognizer
from rangeface.pipeline import Trace
from rangeface.types import RangeImage

_EVERY_S = 0.2
_SHARE = 0.2  # of the newest look in the running mean


class Closeups:
    """Looks at the face that is followed, a few times a second, and averages its surface.

    Parameters
    ----------
    every_s : float
        Between two looks, s: each takes as long as a frame.
    """

    def __init__(self, every_s: float = _EVERY_S) -> None:
        self._every_s = every_s
        self._last_s = -np.inf
        self._surface: tuple[int, RangeImage] | None = None

    @property
    def surface(self) -> tuple[int, RangeImage] | None:
        """Number of the track and its averaged frontal image."""
        return self._surface

    def due(self) -> bool:
        """Whether it is time for a look; the clock starts anew if so."""
        now = time.monotonic()
        if now - self._last_s < self._every_s:
            return False
        self._last_s = now
        return True

    def look(self, live: LiveRecognizer, track: int | None) -> Trace | None:
        """What the last frames show of a track's face; None where there is none."""
        trace = None if track is None else live.closeup(track)
        if track is None or (self._surface is not None and self._surface[0] != track):
            self._surface = None
        if track is not None and trace is not None and trace.frontal is not None:
            kept = None if self._surface is None else self._surface[1]
            self._surface = track, _mean(kept, trace.frontal)
        return trace


def _mean(kept: RangeImage | None, new: RangeImage) -> RangeImage:
    """The running mean where both are measured, else whichever is."""
    if kept is None or kept.camera != new.camera:
        return new
    mean = (1.0 - _SHARE) * kept.depth + _SHARE * new.depth
    either = np.where(new.mask, new.depth, kept.depth)
    return RangeImage(np.where(kept.mask & new.mask, mean, either), new.camera)
