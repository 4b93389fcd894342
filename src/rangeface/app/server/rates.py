"""How often a key may ask: a token bucket each."""

from __future__ import annotations

import time
from threading import Lock

_MOST = 4096


class Rates:
    """Buckets of `burst` requests, refilled at `per_s`.

    Parameters
    ----------
    per_s, burst : float
        Both > 0.
    """

    def __init__(self, per_s: float, burst: float) -> None:
        self._per_s, self._burst = per_s, burst
        self._lock = Lock()
        self._buckets: dict[str, tuple[float, float]] = {}

    def wait_s(self, who: str) -> float:
        """Take one; 0, or how long to wait for the next, s."""
        now = time.monotonic()
        with self._lock:
            left, then = self._buckets.pop(who, (self._burst, now))
            left = min(self._burst, left + (now - then) * self._per_s)
            allowed = left >= 1.0
            self._buckets[who] = (left - 1.0 if allowed else left), now
            if len(self._buckets) > _MOST:  # the one that has been quiet longest
                del self._buckets[next(iter(self._buckets))]
        return 0.0 if allowed else (1.0 - left) / self._per_s
