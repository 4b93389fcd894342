"""Everybody who looks on: each gets the newest frame it can take, and learns what it missed."""

from __future__ import annotations

import asyncio
from collections import deque
from threading import Lock

#: Frames that may be on their way to one onlooker and not yet shown.
_ON_THE_WAY = 2
#: Replies that may wait for one onlooker; who asks more without reading is let go.
_MOST_REPLIES = 64

Message = bytes | str


class Seat:
    """One onlooker: at most one frame, one state and a few replies wait for it.

    To be used in its event loop, except where `Audience` says otherwise.
    """

    def __init__(self) -> None:
        self.loop = asyncio.get_running_loop()
        self._frame: tuple[int, bytes] | None = None
        self._state: str | None = None
        self._replies: deque[str] = deque()
        self._sent: deque[int] = deque()
        self._missed = 0
        self._changed = asyncio.Event()

    @property
    def missed(self) -> int:
        """Frames that a newer one replaced before they could be sent."""
        return self._missed

    def offer(self, number: int, frame: bytes) -> None:
        """Let a frame wait; one that waits already is dropped and counted."""
        self._missed += self._frame is not None
        self._frame = number, frame
        self._changed.set()

    def tell(self, state: str) -> None:
        """Let a state wait, in place of an older one."""
        self._state = state
        self._changed.set()

    def reply(self, text: str) -> None:
        """Let a reply wait.

        Raises
        ------
        ConnectionError
            The onlooker asks and does not read.
        """
        if len(self._replies) >= _MOST_REPLIES:
            raise ConnectionError("too many replies wait")
        self._replies.append(text)
        self._changed.set()

    def seen(self, number: int) -> None:
        """The onlooker has shown this frame, and so all before it."""
        while self._sent and self._sent[0] <= number:
            self._sent.popleft()
        self._changed.set()

    async def next(self) -> Message:
        """What is to be sent next: replies first, then the state, then a frame.

        A frame is preceded by the number of those that were missed (uint32, little-endian).
        """
        while True:
            if self._replies:
                return self._replies.popleft()
            if self._state is not None:
                state, self._state = self._state, None
                return state
            if self._frame is not None and len(self._sent) < _ON_THE_WAY:
                (number, frame), self._frame = self._frame, None
                self._sent.append(number)
                return self._missed.to_bytes(4, "little") + frame
            self._changed.clear()
            await self._changed.wait()


class Audience:
    """All seats. `show` and `tell` may be called from any thread."""

    def __init__(self) -> None:
        self._seats: set[Seat] = set()
        self._lock = Lock()

    def __len__(self) -> int:
        return len(self._seats)

    def join(self, seat: Seat) -> None:
        """Let somebody look on."""
        with self._lock:
            self._seats.add(seat)

    def leave(self, seat: Seat) -> None:
        """Forget an onlooker."""
        with self._lock:
            self._seats.discard(seat)

    def show(self, number: int, frame: bytes) -> None:
        """Offer a frame to everybody."""
        for seat in self._everybody():
            seat.loop.call_soon_threadsafe(seat.offer, number, frame)

    def tell(self, state: str) -> None:
        """Tell everybody the state."""
        for seat in self._everybody():
            seat.loop.call_soon_threadsafe(seat.tell, state)

    def _everybody(self) -> list[Seat]:
        with self._lock:
            return [seat for seat in self._seats if not seat.loop.is_closed()]
