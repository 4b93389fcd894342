"""Who did what to a gallery, without a name and without biometric data."""

from __future__ import annotations

from datetime import UTC, datetime

from rangeface.gallery._database import Database
from rangeface.gallery._protocol import AuditEntry
from rangeface.gallery._record import digest


def note(db: Database, action: str, person: int = 0) -> None:
    """Append a line; each line's digest covers the one before, so none can be cut out."""
    at = datetime.now(UTC).isoformat(timespec="milliseconds")
    mark = digest(_last(db), at, action, person)
    db.run(
        "INSERT INTO audit (at, action, person, digest) VALUES (?, ?, ?, ?)",
        at, action, person, mark,
    )  # fmt: skip
    db.run("UPDATE meta SET value = ? WHERE key = 'last audit line'", mark)


def read(db: Database) -> tuple[AuditEntry, ...]:
    """All lines, oldest first.

    Raises
    ------
    GalleryError
        A line was altered or removed.
    """
    entries, last = [], b""
    for at, action, person, mark in db.all(
        "SELECT at, action, person, digest FROM audit ORDER BY id"
    ):
        if mark != digest(last, at, action, person):
            raise db.damaged("the audit log was altered")
        entries.append(AuditEntry(datetime.fromisoformat(at), action, person))
        last = mark
    if last != _last(db):
        raise db.damaged("the audit log was cut off")
    return tuple(entries)


def _last(db: Database) -> bytes:
    (mark,) = db.one("SELECT value FROM meta WHERE key = 'last audit line'")
    if not isinstance(mark, bytes):
        raise db.damaged("the end of the audit log was altered")
    return mark
