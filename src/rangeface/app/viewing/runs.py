"""One source on its way through the recogniser."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass

from rangeface.sources import Newest, Player, Source

_OVER = 30  # frames over which the rate is measured


@dataclass(frozen=True, eq=False)
class Run:
    """A source that plays.

    Parameters
    ----------
    address : str
        Of the source.
    player : Player
        Plays, pauses and steps it.
    frames : Newest
        What is to be looked at; closing it ends the run.
    """

    address: str
    player: Player
    frames: Newest

    @classmethod
    def of(cls, address: str, source: Source) -> Run:
        """A camera cannot be told to wait: the player holds its frames back where it is paused."""
        player = source if isinstance(source, Player) else Player(source, speed=None)
        return cls(address, player, Newest(player))


class Rate:
    """Frames a second over the last thirty."""

    def __init__(self) -> None:
        self._ticks: deque[float] = deque(maxlen=_OVER)

    def tick(self) -> float:
        """Count a frame; the rate so far, NaN at the first."""
        self._ticks.append(time.monotonic())
        if len(self._ticks) < 2:
            return float("nan")
        return (len(self._ticks) - 1) / max(self._ticks[-1] - self._ticks[0], 1e-6)
