"""Frames at their own speed, faster, slower, or one by one."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from threading import Condition

from rangeface.errors import ParameterError
from rangeface.sources._protocol import Closing, Frame, Source


class Player(Closing):
    """Plays a source: hands out each frame when its time has come.

    Parameters
    ----------
    source : Source
        Of frames that are ready at once: a recording, the synthetic camera.
    speed : float, optional
        1 is the speed of the recording, 2 twice that; None: each frame as soon as it is asked
        for. > 0.
    playing : bool
        False: paused at the first frame.

    Raises
    ------
    ParameterError
        The speed is not > 0.

    Notes
    -----
    `play`, `pause`, `step` and `close` may be called from any thread. A source that is slower
    than its own frame rate sets the pace: lateness is not caught up.
    """

    def __init__(self, source: Source, *, speed: float | None = 1.0, playing: bool = True) -> None:
        if speed is not None and not speed > 0:
            raise ParameterError(f"speed: must be > 0, got {speed}")
        self._source = source
        self._speed = speed
        self._playing = playing
        self._steps = 0
        self._closed = False
        self._start: float | None = None  # our clock at time_s = 0; None: set by the next frame
        self._changed = Condition()

    @property
    def name(self) -> str:
        """The source's address."""
        return self._source.name

    @property
    def rate_hz(self) -> float:
        """Frames a second that come out."""
        return self._source.rate_hz * (self._speed or 1.0)

    @property
    def playing(self) -> bool:
        """Whether frames come by themselves."""
        return self._playing

    def play(self) -> None:
        """Go on from where it was paused."""
        with self._changed:
            self._playing, self._start = True, None
            self._changed.notify_all()

    def pause(self) -> None:
        """Hold the next frame back."""
        with self._changed:
            self._playing = False
            self._changed.notify_all()

    def step(self) -> None:
        """Let one frame out of a paused player."""
        with self._changed:
            self._steps += 1
            self._changed.notify_all()

    def close(self) -> None:
        """End the iteration and close the source."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._source.close()

    def __iter__(self) -> Iterator[Frame]:
        for frame in self._source:
            if not self._wait_for(frame.time_s):
                return
            yield replace(frame, arrived_s=time.monotonic())

    def _wait_for(self, time_s: float) -> bool:
        """Wait until a frame of that time is due; False where the player was closed."""
        with self._changed:
            while not self._closed:
                if not self._playing:
                    if self._steps:
                        self._steps -= 1
                        return True
                    self._changed.wait()
                    continue
                if self._speed is None:
                    return True
                now = time.monotonic()
                if self._start is None:
                    self._start = now - time_s / self._speed
                due = self._start + time_s / self._speed
                if now >= due:
                    self._start += max(now - due - 1.0 / self.rate_hz, 0.0)
                    return True
                self._changed.wait(due - now)
        return False
