"""The hand-over from a camera's thread: bounded, and the newest frame wins."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from threading import Condition, Thread

from rangeface.errors import ParameterError
from rangeface.sources._protocol import Closing, Frame, Source


class Newest(Closing):
    """Reads a source in a thread of its own and keeps only its newest frames.

    Parameters
    ----------
    source : Source
        Read from the first iteration on.
    capacity : int
        Frames that may wait, ≥ 1: at 30 frames/s four of them bridge one closer look at a face.
        Where one more comes the oldest is dropped and counted, so a slow reader never falls behind
        by more than this.

    Raises
    ------
    ParameterError
        The capacity is below 1.

    Notes
    -----
    What the source raises is raised to the reader, after the frames that came before. `close`
    wakes a waiting reader up.
    """

    def __init__(self, source: Source, *, capacity: int = 4) -> None:
        if capacity < 1:
            raise ParameterError(f"capacity: must be ≥ 1, got {capacity}")
        self._source = source
        self._waiting: deque[Frame] = deque()
        self._capacity = capacity
        self._dropped = 0
        self._ended = False
        self._failure: BaseException | None = None
        self._changed = Condition()
        self._thread: Thread | None = None

    @property
    def name(self) -> str:
        """The source's address."""
        return self._source.name

    @property
    def rate_hz(self) -> float:
        """The source's frame rate."""
        return self._source.rate_hz

    @property
    def dropped(self) -> int:
        """Frames thrown away so far."""
        return self._dropped

    def close(self) -> None:
        """End the iteration and close the source."""
        with self._changed:
            self._ended = True
            self._waiting.clear()
            self._changed.notify_all()
        self._source.close()
        if self._thread is not None:
            self._thread.join(timeout=2.0)  # a device may hold its thread until its own timeout

    def __iter__(self) -> Iterator[Frame]:
        if self._thread is None:
            thread = Thread(target=self._read, name=f"read {self.name}", daemon=True)
            thread.start()  # before `close`, in another thread, may try to join it
            self._thread = thread
        while (frame := self._next()) is not None:
            yield frame

    def _next(self) -> Frame | None:
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._ended)
            if self._waiting:
                return replace(self._waiting.popleft(), dropped=self._dropped)
            if self._failure is not None:
                raise self._failure
            return None

    def _read(self) -> None:
        try:
            for frame in self._source:
                with self._changed:
                    if self._ended:
                        return
                    if len(self._waiting) == self._capacity:
                        self._waiting.popleft()
                        self._dropped += 1
                    self._waiting.append(frame)
                    self._changed.notify_all()
        except Exception as failure:  # handed to the reader, who must hear of it
            self._failure = failure
        finally:
            with self._changed:
                self._ended = True
                self._changed.notify_all()
