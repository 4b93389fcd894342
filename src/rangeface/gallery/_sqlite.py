"""A gallery in one SQLite file."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import date
from os import PathLike
from pathlib import Path
from typing import Self

from rangeface.errors import GalleryError
from rangeface.gallery import _audit
from rangeface.gallery._database import Database
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
from rangeface.gallery._record import consent_from_text, consent_to_text, decode, digest, encode
from rangeface.gallery._schema import migrate
from rangeface.gallery._vault import KEY_VARIABLE, Vault
from rangeface.types import Template

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
    the exclusive or of all digests (the seal) is kept beside them: a flipped byte, a lost or a
    swapped record is noticed when the gallery is next viewed, and never changes an answer.
    After `delete` no part of the template is left in the file.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        *,
        create: bool = True,
        key: bytes | None = None,
        timeout_s: float = 10.0,
    ) -> None:
        if not create and not Path(path).is_file():
            raise GalleryError(f"{path}: no such gallery; enrol somebody first")
        self._vault = None if key is None else Vault(key)
        self._records: dict[int, tuple[str, bytes, Template]] = {}
        self._people: dict[int, tuple[str, Consent | None]] = {}
        self._version: tuple[int, int, int] | None = None
        self._view: tuple[date, View] | None = None
        self._db = Database(Path(path), timeout_s)
        try:
            proof = {} if self._vault is None else {"key proof": self._vault.seal(_PROOF, "")}
            migrate(self._db, proof)
            self._check_key()
        except BaseException:
            self._db.close()
            raise

    @property
    def fingerprint(self) -> str | None:
        """Of the model that made the templates; None where nobody is enrolled."""
        with self._db.transaction():
            self._refresh()
            return self._fingerprint()

    def enroll(self, subject: str, template: Template, *, consent: Consent | None = None) -> None:
        """Add a template of a person; a new consent replaces the old."""
        self.enroll_many([(subject, template, consent)])

    def enroll_many(self, records: Iterable[Record]) -> None:
        """Add all of the (subject, template, consent), or none of them, in one durable write."""
        with self._db.transaction(write=True):
            self._refresh()
            for subject, template, consent in records:
                check_subject(subject)
                check_fingerprint(self._fingerprint(), template.fingerprint, str(self._db.path))
                first = next((t for _, _, t in self._records.values()), None)
                check_shape(first, template, str(self._db.path))
                self._put_template(self._put_person(subject, consent), subject, template)
            self._remember()

    def delete(self, subject: str) -> int:
        """Remove all templates of a person without a trace; gives their number."""
        with self._db.transaction(write=True):
            self._refresh()
            person, mark = self._person(subject)
            marks = self._db.all("SELECT digest FROM templates WHERE person = ?", person)
            self._db.run("DELETE FROM templates WHERE person = ?", person)
            self._db.run("DELETE FROM people WHERE id = ?", person)
            self._reseal(mark, *(m for (m,) in marks))
            _audit.note(self._db, "deleted", person)
            del self._people[person]
            self._records = {i: r for i, r in self._records.items() if r[0] != subject}
            self._remember()
            return len(marks)

    def subjects(self) -> tuple[str, ...]:
        """Who is enrolled, expired consents included, in the order of enrolment."""
        with self._db.transaction():
            self._refresh()
            return tuple(name for name, _ in self._people.values())

    def consent(self, subject: str) -> Consent | None:
        """The ground on which a person is enrolled."""
        with self._db.transaction():
            self._refresh()
            return self._people[self._person(subject)[0]][1]

    def templates(self, subject: str) -> tuple[Template, ...]:
        """Templates of a person, oldest first."""
        with self._db.transaction():
            self._refresh()
            self._person(subject)
            return tuple(t for name, _, t in self._records.values() if name == subject)

    def view(self, *, today: date | None = None) -> View:
        """Everything that may be searched today (default: the computer's date)."""
        day = today or date.today()
        with self._db.transaction():
            self._refresh()
            if self._view is None or self._view[0] != day:
                searchable = {n for n, c in self._people.values() if c is None or c.holds(day)}
                kept = [(n, t) for n, _, t in self._records.values() if n in searchable]
                self._view = day, stack(kept, self._fingerprint())
            return self._view[1]

    def audit(self) -> tuple[AuditEntry, ...]:
        """What was done, oldest first, without names; altered or missing lines are noticed."""
        with self._db.transaction():
            return _audit.read(self._db)

    def note(self, action: str) -> None:
        """Append a line of the caller's to the audit log."""
        with self._db.transaction(write=True):
            _audit.note(self._db, action)

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
        self._db.copy_to(Path(target))

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()

    # ── from the file to memory ──────────────────────────────────────────────────────────

    def _refresh(self) -> None:
        """Load what others wrote or removed since the last time, and check the seal."""
        if self._version == self._db.version:
            return
        people, records, seal = {}, {}, bytes(16)
        for person, name, reference, expires, mark in self._db.all(
            "SELECT id, name, consent, expires, digest FROM people ORDER BY id"
        ):
            if mark != digest(name, reference, expires):
                raise self._db.damaged("a record was altered")
            people[person] = name, consent_from_text(reference, expires)
            seal = _xor(seal, mark)
        for record, person, mark in self._db.all("SELECT id, person, digest FROM templates"):
            known = self._records.get(record)
            if known is None or known[1] != mark:
                name, _ = people.get(person, ("", None))
                known = self._load(record, name, mark)
            records[record] = known
            seal = _xor(seal, mark)
        if seal != self._seal():
            raise self._db.damaged("records are missing")
        self._people, self._records = people, records
        self._remember()

    def _load(self, record: int, name: str, mark: bytes) -> tuple[str, bytes, Template]:
        (payload,) = self._db.one("SELECT payload FROM templates WHERE id = ?", record)
        if mark != digest(name, payload):
            raise self._db.damaged("a record was altered")
        return name, mark, decode(self._opened(payload, name))

    def _remember(self) -> None:
        """What is in memory is now what is in the file."""
        self._view, self._version = None, self._db.version

    def _fingerprint(self) -> str | None:
        return next((t.fingerprint for _, _, t in self._records.values()), None)

    def _person(self, subject: str) -> tuple[int, bytes]:
        row = self._db.find("SELECT id, digest FROM people WHERE name = ?", subject)
        if row is None:
            raise GalleryError(f"{self._db.path}: {subject!r} is not enrolled")
        return row[0], row[1]

    # ── from memory to the file ──────────────────────────────────────────────────────────

    def _put_person(self, subject: str, consent: Consent | None) -> int:
        reference, expires = consent_to_text(consent)
        mark = digest(subject, reference, expires)
        known = self._db.find("SELECT id, digest FROM people WHERE name = ?", subject)
        if known is None:
            person = self._db.run(
                "INSERT INTO people (name, consent, expires, digest) VALUES (?, ?, ?, ?)",
                subject, reference, expires, mark,
            )  # fmt: skip
            self._reseal(mark)
            self._people[person] = subject, consent
            return person
        person = known[0]
        if consent is not None:
            self._db.run(
                "UPDATE people SET consent = ?, expires = ?, digest = ? WHERE id = ?",
                reference, expires, mark, person,
            )  # fmt: skip
            self._reseal(known[1], mark)
            self._people[person] = subject, consent
            _audit.note(self._db, "consent", person)
        return person

    def _put_template(self, person: int, subject: str, template: Template) -> None:
        payload = encode(template)
        if self._vault is not None:
            payload = self._vault.seal(payload, subject)
        mark = digest(subject, payload)
        record = self._db.run(
            "INSERT INTO templates (person, payload, digest) VALUES (?, ?, ?)",
            person, payload, mark,
        )  # fmt: skip
        self._reseal(mark)
        _audit.note(self._db, "enrolled", person)
        self._records[record] = subject, mark, template

    def _reseal(self, *marks: bytes) -> None:
        seal = self._seal()
        for mark in marks:
            seal = _xor(seal, mark)
        self._db.run("UPDATE meta SET value = ? WHERE key = 'seal'", seal)

    def _seal(self) -> bytes:
        (seal,) = self._db.one("SELECT value FROM meta WHERE key = 'seal'")
        if not isinstance(seal, bytes) or len(seal) != 16:
            raise self._db.damaged("the seal is broken")
        return seal

    # ── keys ─────────────────────────────────────────────────────────────────────────────

    def _check_key(self) -> None:
        with self._db.transaction():
            row = self._db.find("SELECT value FROM meta WHERE key = 'key proof'")
        if row is None and self._vault is not None:
            raise GalleryError(
                f"{self._db.path}: is not encrypted; export it and import it into a new gallery"
            )
        if row is not None and self._vault is None:
            raise GalleryError(f"{self._db.path}: is encrypted; give its key in {KEY_VARIABLE}")
        if row is not None:
            self._opened(row[0], "")

    def _opened(self, sealed: bytes, name: str) -> bytes:
        if self._vault is None:
            return sealed
        try:
            return self._vault.open(sealed, name)
        except GalleryError as error:
            raise GalleryError(f"{self._db.path}: {error}") from error


def _xor(a: bytes, b: bytes) -> bytes:
    return (int.from_bytes(a) ^ int.from_bytes(b)).to_bytes(len(a))
