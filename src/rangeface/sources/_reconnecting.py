"""A source that comes back after it was unplugged."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from threading import Event

from rangeface.errors import ParameterError, RangeFaceError
from rangeface.sources._protocol import Closing, Frame, Source


class Reconnecting(Closing):
    """Opens a source again whenever it breaks.

    Parameters
    ----------
    opener : callable
        Opens the source; raises `SourceError`, `ScanError` or `OSError` while it cannot.
    patience_s : float
        So long it tries in a row before it gives up and raises the last failure, s, > 0.
    wait_s : float
        Before the second try, s, > 0; each further wait is twice as long, up to `max_wait_s`.
    max_wait_s : float
        Longest wait between two tries, s.

    Raises
    ------
    ParameterError
        A time is not > 0.

    Notes
    -----
    Numbers and times of the frames go on; the time that was lost is counted. A source that ends
    by itself ends for good.
    """

    def __init__(
        self,
        opener: Callable[[], Source],
        *,
        patience_s: float = 60.0,
        wait_s: float = 0.1,
        max_wait_s: float = 1.5,
    ) -> None:
        if not (patience_s > 0 and wait_s > 0 and max_wait_s > 0):
            raise ParameterError("patience_s, wait_s, max_wait_s: must be > 0")
        self._opener = opener
        self._patience_s = patience_s
        self._wait_s = wait_s
        self._max_wait_s = max_wait_s
        self._closed = Event()
        self._source: Source | None = None
        self.reconnects = 0
        self.name, self.rate_hz = "", 30.0

    def close(self) -> None:
        """End the iteration, a wait included, and close the source."""
        self._closed.set()
        if self._source is not None:
            self._source.close()

    def __iter__(self) -> Iterator[Frame]:
        broke_s, wait_s = time.monotonic(), self._wait_s
        number, time_s, last_s = 0, 0.0, time.monotonic()
        while not self._closed.is_set():
            try:
                with self._opener() as source:
                    self._source, self.name, self.rate_hz = source, source.name, source.rate_hz
                    start, start_s = number, time_s + (time.monotonic() - last_s) * (number > 0)
                    for frame in source:
                        number, time_s = start + frame.number + 1, start_s + frame.time_s
                        last_s, wait_s = time.monotonic(), self._wait_s
                        yield replace(frame, number=number - 1, time_s=time_s)
                        if self._closed.is_set():
                            return
                        broke_s = time.monotonic()
                return
            except (RangeFaceError, OSError):
                if time.monotonic() - broke_s > self._patience_s:
                    raise
                self.reconnects += 1
                self._closed.wait(wait_s)
                wait_s = min(2.0 * wait_s, self._max_wait_s)
