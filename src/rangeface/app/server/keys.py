"""Keys: random, scoped, with an expiry; the file holds their hashes only."""

from __future__ import annotations

import hashlib
import hmac
import json
import os
import secrets
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from pathlib import Path
from threading import Lock
from typing import Any

from rangeface.errors import ParameterError

_PREFIX = "rf"


class Scope(StrEnum):
    """What a key may allow."""

    IDENTIFY = "identify"
    VERIFY = "verify"
    ENROLL = "enroll"
    DELETE = "delete"
    LIST = "list"
    STATUS = "status"
    SCORES = "scores"
    ADMIN = "admin"


@dataclass(frozen=True)
class Key:
    """What is known of a key: never the key itself.

    Parameters
    ----------
    id : str
        Its public part, which logs may show.
    name : str
        Who has it.
    scopes : frozenset of Scope
        What it allows.
    expires : datetime, optional
        Last moment, UTC; None: until it is revoked.
    sha256 : str
        Hash of the secret part, hexadecimal.
    """

    id: str
    name: str
    scopes: frozenset[Scope]
    expires: datetime | None
    sha256: str

    def opened_by(self, secret: str) -> bool:
        """Whether this is the secret, compared in constant time."""
        return hmac.compare_digest(_hash(secret), self.sha256)

    def expired(self, now: datetime) -> bool:
        """Whether its time has passed."""
        return self.expires is not None and now > self.expires


class KeyRing:
    """The keys of a file; what another process adds or revokes counts at once.

    Parameters
    ----------
    path : Path
        A JSON file that only its owner may read.

    Raises
    ------
    ParameterError
        The file is damaged, or a key to revoke is unknown.

    Notes
    -----
    A secret is 256 random bits, so that one round of SHA-256 is enough: there is no dictionary
    of such secrets to try.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = Lock()
        self._stamp: tuple[int, int, int] | None = None
        self._keys: dict[str, Key] = {}

    def add(self, name: str, scopes: Iterable[Scope], *, expires: datetime | None = None) -> str:
        """Make a key, and give its text: the only time that it is seen."""
        with self._lock:
            keys = dict(self._read())
            identity, secret = secrets.token_hex(4), secrets.token_urlsafe(32)
            keys[identity] = Key(identity, name, frozenset(scopes), expires, _hash(secret))
            self._write(keys)
        return f"{_PREFIX}.{identity}.{secret}"

    def revoke(self, identity: str) -> None:
        """Take a key out."""
        with self._lock:
            keys = dict(self._read())
            if keys.pop(identity, None) is None:
                raise ParameterError(f"{self.path}: no key {identity!r}")
            self._write(keys)

    def all(self) -> tuple[Key, ...]:
        """All keys, oldest first."""
        with self._lock:
            return tuple(self._read().values())

    def find(self, text: str) -> Key | None:
        """The key that a text opens, expired or not; None if there is none."""
        prefix, _, rest = text.partition(".")
        identity, _, secret = rest.partition(".")
        with self._lock:
            key = self._read().get(identity)
        if prefix != _PREFIX or key is None or not key.opened_by(secret):
            return None
        return key

    def _read(self) -> dict[str, Key]:
        try:
            stat = self.path.stat()
        except FileNotFoundError:
            self._keys, self._stamp = {}, None
            return self._keys
        stamp = stat.st_ino, stat.st_mtime_ns, stat.st_size
        if stamp != self._stamp:
            try:
                table = json.loads(self.path.read_text(encoding="utf-8"))["keys"]
                self._keys = {entry["id"]: _from_json(entry) for entry in table}
            except (ValueError, KeyError, TypeError) as error:
                raise ParameterError(f"{self.path}: no file of keys ({error})") from error
            self._stamp = stamp
        return self._keys

    def _write(self, keys: dict[str, Key]) -> None:
        table = [_to_json(key) for key in keys.values()]
        write_private(self.path, json.dumps({"keys": table}, indent=1) + "\n")


def write_private(path: Path, text: str) -> None:
    """Write a file that only its owner may read; it appears whole or not at all."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    file = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    try:
        with os.fdopen(file, "w", encoding="utf-8") as out:
            out.write(text)
            out.flush()
            os.fsync(out.fileno())
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def _hash(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()


def _to_json(key: Key) -> dict[str, Any]:
    return {
        "id": key.id,
        "name": key.name,
        "scopes": sorted(key.scopes),
        "expires": key.expires.isoformat() if key.expires else None,
        "sha256": key.sha256,
    }


def _from_json(entry: dict[str, Any]) -> Key:
    expires = entry["expires"]
    return Key(
        entry["id"],
        entry["name"],
        frozenset(map(Scope, entry["scopes"])),
        datetime.fromisoformat(expires).astimezone(UTC) if expires else None,
        entry["sha256"],
    )
