"""Who looks at the page: an invitation, good for once, becomes a session kept in a cookie."""

from __future__ import annotations

import hashlib
import secrets
import time
from collections.abc import Iterable
from dataclasses import dataclass
from threading import Lock

from rangeface.app.server.keys import Scope

LIFETIME_S = 12 * 3600.0
_MOST = 256


@dataclass(frozen=True)
class Session:
    """What an onlooker may do, and until when (by `time.monotonic`)."""

    scopes: frozenset[Scope]
    end_s: float

    def allows(self, scope: Scope) -> bool:
        """Whether it may, now."""
        return scope in self.scopes and time.monotonic() < self.end_s


class Sessions:
    """Invitations and sessions; in memory only, so a restart ends them all.

    Notes
    -----
    Both are 256 random bits, kept as hashes. An invitation is carried in the fragment of the
    page's address, which browsers do not send: it stands in no log and in no Referer.
    """

    def __init__(self) -> None:
        self._invitations: dict[bytes, frozenset[Scope]] = {}
        self._sessions: dict[bytes, Session] = {}
        self._lock = Lock()

    def invite(self, scopes: Iterable[Scope] = tuple(Scope)) -> str:
        """A token that opens one session."""
        token = secrets.token_urlsafe(32)
        with self._lock:
            self._invitations[_hash(token)] = frozenset(scopes)
        return token

    def accept(self, token: str) -> str | None:
        """The cookie of a new session; None if the token is unknown or used up."""
        with self._lock:
            scopes = self._invitations.pop(_hash(token), None)
        return None if scopes is None else self.open(scopes)

    def open(self, scopes: Iterable[Scope]) -> str:
        """The cookie of a new session with these scopes."""
        cookie, now = secrets.token_urlsafe(32), time.monotonic()
        with self._lock:
            self._sessions = {h: s for h, s in self._sessions.items() if s.end_s > now}
            while len(self._sessions) >= _MOST:
                del self._sessions[next(iter(self._sessions))]
            self._sessions[_hash(cookie)] = Session(frozenset(scopes), now + LIFETIME_S)
        return cookie

    def find(self, cookie: str | None) -> Session | None:
        """The session of a cookie, unless it is over."""
        with self._lock:
            session = self._sessions.get(_hash(cookie or ""))
        return session if session is not None and session.end_s > time.monotonic() else None


def _hash(token: str) -> bytes:
    return hashlib.sha256(token.encode()).digest()
