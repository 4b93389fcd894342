"""How often somebody may be refused: five times, then a pause, and a stop at fifty."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

from rangeface.app.server.problems import Cause, RefusalError


@dataclass
class Attempt:
    """One attempt on its way.

    Parameters
    ----------
    failed : bool, optional
        True: refused; False: accepted; None: nothing was compared, which counts as neither.
    """

    failed: bool | None = None


@dataclass(frozen=True)
class _Streak:
    failures: int = 0
    until: float = 0.0


class Attempts:
    """Counts refused attempts in a row, for each key and for each claimed name.

    Parameters
    ----------
    failures : int
        In a row before a pause; every multiple of it brings another.
    pause_s : float
        The pause, s.
    stop : int
        In a row after which only `reset` opens the way again.
    clock : callable
        Seconds that only grow.

    Notes
    -----
    NIST SP 800-63B, 5.2.3: at most five consecutive failed biometric attempts, then at least 30 s
    of delay. Attempts that are still on their way may all fail, so no more of them are let in at
    a time than may fail; the others wait. All of this runs in one event loop.
    """

    def __init__(
        self, failures: int, pause_s: float, stop: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._failures, self._pause_s, self._stop, self._clock = failures, pause_s, stop, clock
        self._streaks: dict[str, _Streak] = {}
        self._on_their_way: Counter[str] = Counter()
        self._landed = asyncio.Condition()

    @asynccontextmanager
    async def attempt(self, who: str) -> AsyncIterator[Attempt]:
        """Let an attempt in, and count how it ends.

        Raises
        ------
        RefusalError
            Too many failures in a row.
        """
        async with self._landed:
            await self._landed.wait_for(lambda: self._allowed(who))
            self._on_their_way[who] += 1
        attempt = Attempt()
        try:
            yield attempt
        finally:
            async with self._landed:
                self._on_their_way[who] -= 1
                self._count(who, attempt.failed)
                self._landed.notify_all()

    def reset(self) -> int:
        """Forget all failures; gives the number of those who had any."""
        count = len(self._streaks)
        self._streaks = {}
        return count

    def _allowed(self, who: str) -> bool:
        streak, now = self._streaks.get(who, _Streak()), self._clock()
        if streak.failures >= self._stop:
            raise RefusalError(Cause.ATTEMPTS_STOPPED, f"after {streak.failures} failures in a row")
        if now < streak.until:
            raise RefusalError(Cause.TOO_MANY_FAILURES, retry_s=streak.until - now)
        left = min(self._failures - streak.failures % self._failures, self._stop - streak.failures)
        return self._on_their_way[who] < left

    def _count(self, who: str, failed: bool | None) -> None:
        if not self._on_their_way[who]:
            del self._on_their_way[who]
        if failed is None:
            return
        if not failed:
            self._streaks.pop(who, None)
            return
        failures = self._streaks.get(who, _Streak()).failures + 1
        pause_s = self._pause_s if failures % self._failures == 0 else 0.0
        self._streaks[who] = _Streak(failures, self._clock() + pause_s)
