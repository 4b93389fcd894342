"""Who did what to a gallery, without a name and without biometric data."""

from __future__ import annotations

import sqlite3
from datetime import UTC, datetime

from rangeface.errors import GalleryError
from rangeface.gallery._protocol import AuditEntry
from rangeface.gallery._record import digest


def note(db: sqlite3.Connection, action: str, person: int = 0) -> None:
    """Append a line; each line's digest covers the one before, so none can be cut out."""
    at = datetime.now(UTC).isoformat(timespec="milliseconds")
    mark = digest(_last(db), at, action, person)
    db.execute(
        "INSERT INTO audit (at, action, person, digest) VALUES (?, ?, ?, ?)",
        (at, action, person, mark),
    )
    db.execute("UPDATE meta SET value = ? WHERE key = 'last audit line'", (mark,))


def read(db: sqlite3.Connection) -> tuple[AuditEntry, ...]:
    """All lines, oldest first.

    Raises
    ------
    GalleryError
        A line was altered or removed.
    """
    entries, last = [], b""
    for at, action, person, mark in db.execute(
        "SELECT at, action, person, digest FROM audit ORDER BY id"
    ):
        if mark != digest(last, at, action, person):
            raise GalleryError("the audit log was altered")
        entries.append(AuditEntry(datetime.fromisoformat(at), action, person))
        last = mark
    if last != _last(db):
        raise GalleryError("the audit log was cut off")
    return tuple(entries)


def _last(db: sqlite3.Connection) -> bytes:
    row = db.execute("SELECT value FROM meta WHERE key = 'last audit line'").fetchone()
    if row is None or not isinstance(row[0], bytes):
        raise GalleryError("the end of the audit log is missing")
    return row[0]
