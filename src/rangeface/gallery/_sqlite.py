"""A gallery in one SQLite file."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import date
from os import PathLike
from pathlib import Path
from threading import RLock
from typing import Any, Self

from rangeface.errors import GalleryError
from rangeface.gallery import _audit as audit
from rangeface.gallery._protocol import (
    AuditEntry,
    Consent,
    Record,
    View,
    check_fingerprint,
    check_shape,
    check_subject,
    stack,
)
from rangeface.gallery._record import decode, digest, encode
from rangeface.gallery._schema import APPLICATION_ID, migrate
from rangeface.gallery._vault import KEY_VARIABLE, Vault
from rangeface.types import Template

# A rollback journal, not WAL: SQLite before 3.51.3 can lose acknowledged WAL commits (the reset
# bug), and a WAL file keeps what was deleted. EXTRA syncs the folder too, so that a journal which
# a power cut brings back cannot undo an acknowledged write. Deleted bytes are overwritten.
_PRAGMAS = (
    "journal_mode = DELETE",
    "synchronous = EXTRA",
    "secure_delete = ON",
    "foreign_keys = ON",
    "cell_size_check = ON",
    "trusted_schema = OFF",
)
_PROOF = b"rangeface gallery"


class SqliteGallery:
    """Enrolled templates in one SQLite file; several processes may read and write it.

    Parameters
    ----------
    path : str or PathLike
        The file.
    create : bool
        Make the file where it is missing.
    key : bytes, optional
        32 bytes: templates are sealed with AES-256-GCM under their person's name. A gallery is
        encrypted from its first moment or never; names and consents are not.
    timeout_s : float
        How long to wait for another process's write, s.

    Raises
    ------
    GalleryError
        The file is missing, no gallery, damaged, of a newer version, read-only, or the disk is
        full; the key is missing, wrong or not asked for; a template of another model or shape
        is enrolled; a person is unknown.

    Notes
    -----
    A write that returned survives kill −9 and power loss. Every record carries a digest, and
    the exclusive or of all digests is kept beside them: a flipped byte, a lost or a swapped
    record is noticed when the gallery is next viewed, and never changes an answer. After
    `delete` no part of the template is left in the file.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        *,
        create: bool = True,
        key: bytes | None = None,
        timeout_s: float = 10.0,
    ) -> None:
        self._path = Path(path)
        self._vault = None if key is None else Vault(key)
        self._lock = RLock()
        self._records: dict[int, tuple[str, bytes, Template]] = {}
        self._people: dict[int, tuple[str, Consent | None]] = {}
        self._version: tuple[int, int] | None = None
        self._view: tuple[date, View] | None = None
        if not create and not self._path.is_file():
            raise GalleryError(f"{self._path}: no such gallery; enrol somebody first")
        with self._guard():
            self._db = sqlite3.connect(
                self._path, timeout=timeout_s, isolation_level=None, check_same_thread=False
            )
            try:
                self._prepare()
            except BaseException:
                self._db.close()
                raise

    @property
    def fingerprint(self) -> str | None:
        """Of the model that made the templates; None where nobody is enrolled."""
        with self._reading():
            return self._fingerprint()

    def enroll(self, subject: str, template: Template, *, consent: Consent | None = None) -> None:
        """Add a template of a person; a new consent replaces the old."""
        self.enroll_many([(subject, template, consent)])

    def enroll_many(self, records: Iterable[Record]) -> None:
        """Add all of the (subject, template, consent), or none of them, in one durable write."""
        with self._writing():
            self._refresh()
            for subject, template, consent in records:
                check_subject(subject)
                check_fingerprint(self._fingerprint(), template.fingerprint, str(self._path))
                first = next((t for _, _, t in self._records.values()), None)
                check_shape(first, template, str(self._path))
                self._put(subject, template, consent)
                self._remember()

    def delete(self, subject: str) -> int:
        """Remove all templates of a person without a trace; gives their number."""
        with self._writing():
            self._refresh()
            person, mark = self._person(subject)
            marks = self._all("SELECT digest FROM templates WHERE person = ?", person)
            self._db.execute("DELETE FROM templates WHERE person = ?", (person,))
            self._db.execute("DELETE FROM people WHERE id = ?", (person,))
            self._reseal(mark, *(m for (m,) in marks))
            audit.note(self._db, "deleted", person)
            del self._people[person]
            self._records = {i: r for i, r in self._records.items() if r[0] != subject}
            self._remember()
            return len(marks)

    def subjects(self) -> tuple[str, ...]:
        """Who is enrolled, expired consents included, in the order of enrolment."""
        with self._reading():
            self._refresh()
            return tuple(name for name, _ in self._people.values())

    def consent(self, subject: str) -> Consent | None:
        """The ground on which a person is enrolled."""
        with self._reading():
            self._refresh()
            return self._people[self._person(subject)[0]][1]

    def templates(self, subject: str) -> tuple[Template, ...]:
        """Templates of a person, oldest first."""
        with self._reading():
            self._refresh()
            self._person(subject)
            return tuple(t for name, _, t in self._records.values() if name == subject)

    def view(self, *, today: date | None = None) -> View:
        """Everything that may be searched today (default: the computer's date)."""
        day = today or date.today()
        with self._reading():
            self._refresh()
            if self._view is None or self._view[0] != day:
                searchable = {n for n, c in self._people.values() if c is None or c.holds(day)}
                kept = [(n, t) for n, _, t in self._records.values() if n in searchable]
                self._view = day, stack(kept, self._fingerprint())
            return self._view[1]

    def audit(self) -> tuple[AuditEntry, ...]:
        """What was done, oldest first, without names; altered or missing lines are noticed."""
        with self._reading():
            return audit.read(self._db)

    def note(self, action: str) -> None:
        """Append a line of the caller's to the audit log."""
        with self._writing():
            audit.note(self._db, action)

    def backup(self, target: str | PathLike[str], *, overwrite: bool = False) -> None:
        """Copy the whole gallery to another file, while others may go on using this one.

        Restoring is the same the other way round: open the backup and copy it over the gallery.

        Parameters
        ----------
        target : str or PathLike
            File to write; it is whole or unchanged, even after a crash.
        overwrite : bool
            Replace what is there.

        Raises
        ------
        GalleryError
            The target exists and may not be replaced, or cannot be written; or this gallery is
            damaged, and a copy of it would be worth nothing.
        """
        if Path(target).exists() and not overwrite:
            raise GalleryError(f"{target}: exists; a backup replaces nothing unless asked")
        self.note("backed up")
        self.view()
        with self._lock, self._guard():
            copy = sqlite3.connect(target)
            try:
                copy.execute("PRAGMA synchronous = EXTRA")
                copy.execute("PRAGMA secure_delete = ON")
                self._db.backup(copy)
            finally:
                copy.close()

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self._db.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()

    # ── what is in the file ──────────────────────────────────────────────────────────────

    def _prepare(self) -> None:
        for pragma in _PRAGMAS:
            self._db.execute(f"PRAGMA {pragma}")
        (tables,) = self._one("SELECT count(*) FROM sqlite_master")
        if tables and self._one("PRAGMA application_id")[0] != APPLICATION_ID:
            raise GalleryError(f"{self._path}: is an SQLite file, but no gallery")
        migrate(self._db, self._path)
        self._check_key(new=tables == 0)

    def _check_key(self, new: bool) -> None:
        if new and self._vault is not None:
            proof = self._vault.seal(_PROOF, "")
            self._db.execute("INSERT OR IGNORE INTO meta VALUES ('key proof', ?)", (proof,))
        row = self._db.execute("SELECT value FROM meta WHERE key = 'key proof'").fetchone()
        if row is None and self._vault is not None:
            raise GalleryError(
                f"{self._path}: is not encrypted; export it and import it into a new gallery"
            )
        if row is not None and self._vault is None:
            raise GalleryError(f"{self._path}: is encrypted; give its key in {KEY_VARIABLE}")
        if row is not None and self._vault is not None:
            self._opened(row[0], "")

    def _opened(self, sealed: bytes, name: str) -> bytes:
        if self._vault is None:
            return sealed
        try:
            return self._vault.open(sealed, name)
        except GalleryError as error:
            raise GalleryError(f"{self._path}: {error}") from error

    def _refresh(self) -> None:
        """Load what others wrote or removed since the last time, and check the seal."""
        if self._version == self._current_version():
            return
        seal = bytes(16)
        self._people = {}
        for person, name, reference, expires, mark in self._all(
            "SELECT id, name, consent, expires, digest FROM people ORDER BY id"
        ):
            self._check_mark(mark, digest(name, reference, expires))
            self._people[person] = name, _consent(reference, expires)
            seal = _xor(seal, mark)
        kept = {}
        for record, person, mark in self._all("SELECT id, person, digest FROM templates"):
            known = self._records.get(record)
            if known is None or known[1] != mark:
                known = self._load(record, person, mark)
            kept[record] = known
            seal = _xor(seal, mark)
        if seal != self._seal():
            raise GalleryError(f"{self._path}: damaged (records are missing); restore a backup")
        self._records = kept
        self._remember()

    def _remember(self) -> None:
        """What is in memory is now what is in the file."""
        self._view, self._version = None, self._current_version()

    def _current_version(self) -> tuple[int, int]:
        # the first counts other connections' commits, the second this one's changes
        return self._one("PRAGMA data_version")[0], self._db.total_changes

    def _load(self, record: int, person: int, mark: bytes) -> tuple[str, bytes, Template]:
        (payload,) = self._one("SELECT payload FROM templates WHERE id = ?", record)
        name = self._people[person][0] if person in self._people else ""
        self._check_mark(mark, digest(name, payload))
        return name, mark, decode(self._opened(payload, name))

    def _put(self, subject: str, template: Template, consent: Consent | None) -> None:
        person = self._put_person(subject, consent)
        payload = encode(template)
        if self._vault is not None:
            payload = self._vault.seal(payload, subject)
        mark = digest(subject, payload)
        cursor = self._db.execute(
            "INSERT INTO templates (person, payload, digest) VALUES (?, ?, ?)",
            (person, payload, mark),
        )
        self._reseal(mark)
        audit.note(self._db, "enrolled", person)
        self._records[int(cursor.lastrowid or 0)] = subject, mark, template

    def _put_person(self, subject: str, consent: Consent | None) -> int:
        known = self._db.execute("SELECT id FROM people WHERE name = ?", (subject,)).fetchone()
        if known and consent is None:
            return int(known[0])
        reference = consent.reference if consent else None
        expires = consent.expires.isoformat() if consent and consent.expires else None
        mark = digest(subject, reference, expires)
        if known:
            (old,) = self._one("SELECT digest FROM people WHERE id = ?", known[0])
            self._db.execute(
                "UPDATE people SET consent = ?, expires = ?, digest = ? WHERE id = ?",
                (reference, expires, mark, known[0]),
            )
            self._reseal(old, mark)
            person = int(known[0])
            audit.note(self._db, "consent", person)
        else:
            cursor = self._db.execute(
                "INSERT INTO people (name, consent, expires, digest) VALUES (?, ?, ?, ?)",
                (subject, reference, expires, mark),
            )
            self._reseal(mark)
            person = int(cursor.lastrowid or 0)
        self._people[person] = subject, consent
        return person

    def _person(self, subject: str) -> tuple[int, bytes]:
        row = self._db.execute(
            "SELECT id, digest FROM people WHERE name = ?", (subject,)
        ).fetchone()
        if row is None:
            raise GalleryError(f"{self._path}: {subject!r} is not enrolled")
        return row[0], row[1]

    def _fingerprint(self) -> str | None:
        self._refresh()
        return next((t.fingerprint for _, _, t in self._records.values()), None)

    def _reseal(self, *marks: bytes) -> None:
        seal = self._seal()
        for mark in marks:
            seal = _xor(seal, mark)
        self._db.execute("UPDATE meta SET value = ? WHERE key = 'seal'", (seal,))

    def _seal(self) -> bytes:
        (seal,) = self._one("SELECT value FROM meta WHERE key = 'seal'")
        if not isinstance(seal, bytes) or len(seal) != 16:
            raise GalleryError(f"{self._path}: damaged (the seal is broken); restore a backup")
        return seal

    def _check_mark(self, kept: bytes, found: bytes) -> None:
        if kept != found:
            raise GalleryError(f"{self._path}: damaged (a record was altered); restore a backup")

    # ── transactions ─────────────────────────────────────────────────────────────────────

    def _one(self, sql: str, *values: Any) -> tuple[Any, ...]:
        row = self._db.execute(sql, values).fetchone()
        if row is None:
            raise GalleryError(f"{self._path}: damaged (a row is missing); restore a backup")
        return tuple(row)

    def _all(self, sql: str, *values: Any) -> list[tuple[Any, ...]]:
        return self._db.execute(sql, values).fetchall()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        with self._transaction("BEGIN IMMEDIATE"):
            yield

    @contextmanager
    def _reading(self) -> Iterator[None]:
        with self._transaction("BEGIN"):
            yield

    @contextmanager
    def _transaction(self, begin: str) -> Iterator[None]:
        with self._lock, self._guard():
            self._db.execute(begin)
            try:
                yield
                self._db.execute("COMMIT")
            except BaseException:
                self._version = None
                if self._db.in_transaction:
                    self._db.execute("ROLLBACK")
                raise

    @contextmanager
    def _guard(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise GalleryError(f"{self._path}: {error}") from error
        except UnicodeDecodeError as error:  # text that sqlite3 hands over is no longer text
            raise GalleryError(f"{self._path}: damaged ({error}); restore a backup") from error


def _consent(reference: str | None, expires: str | None) -> Consent | None:
    if reference is None:
        return None
    return Consent(reference, date.fromisoformat(expires) if expires else None)


def _xor(a: bytes, b: bytes) -> bytes:
    return (int.from_bytes(a) ^ int.from_bytes(b)).to_bytes(len(a))
