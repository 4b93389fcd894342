"""A gallery in one SQLite file."""

from __future__ import annotations

from collections.abc import Callable, Iterable
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
from rangeface.gallery._rows import Known, Rows
from rangeface.gallery._schema import migrate
from rangeface.gallery._vault import Vault
from rangeface.types import Assessment, RangeImage, Template


class SqliteGallery:
    """Enrolled templates in one SQLite file; several processes may read and write it.

    Parameters
    ----------
    path : str or PathLike
        The file.
    create : bool
        Make the file where it is missing.
    key : bytes, optional
        32 bytes: names, consents, templates and frontal images are sealed with AES-256-GCM, each
        under its person. A gallery is encrypted from its first moment or never. Who has the
        file but not the key sees how many people and templates there are, when they came and
        went (the audit log), and nothing else.
    timeout_s : float
        How long to wait for another process's write, s; SQLite's queue is not fair, so that
        among many busy writers one may wait long.

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
        timeout_s: float = 60.0,
    ) -> None:
        if not create and not Path(path).is_file():
            raise GalleryError(f"{path}: no such gallery; enrol somebody first")
        vault = None if key is None else Vault(key)
        self._records: dict[int, Known] = {}
        self._people: dict[int, tuple[str, Consent | None]] = {}
        self._version: tuple[int, int, int] | None = None
        self._view: tuple[date, View] | None = None
        self._db = Database(Path(path), timeout_s)
        self._rows = Rows(self._db, vault)
        try:
            migrate(self._db, self._rows.proof())
            self._take_up()
        except BaseException:
            self._db.close()
            raise

    @property
    def fingerprint(self) -> str | None:
        """Of the model that made the templates; None where nobody is enrolled."""
        with self._db.transaction():
            self._refresh()
            return self._fingerprint()

    def enroll(
        self,
        subject: str,
        template: Template,
        *,
        consent: Consent | None = None,
        frontal: RangeImage | None = None,
    ) -> None:
        """Add a template of a person, and the image to rebuild it from; a new consent counts."""
        with self._db.transaction(write=True):
            self._refresh()
            self._put(subject, template, consent, frontal)
            self._remember()

    def enroll_many(self, records: Iterable[Record]) -> None:
        """Add all of the (subject, template, consent), or none of them, in one durable write."""
        with self._db.transaction(write=True):
            self._refresh()
            for subject, template, consent in records:
                self._put(subject, template, consent)
            self._remember()

    def rebuild(self, make: Callable[[RangeImage, Assessment | None], Template]) -> int:
        """Make every template anew from its frontal image, for another model; all or none.

        Parameters
        ----------
        make : callable
            Frontal image and assessment of the capture → template.

        Returns
        -------
        int
            Number of templates.

        Raises
        ------
        GalleryError
            A template has no frontal image, or the new ones do not fit together.
        """
        with self._db.transaction(write=True):
            self._refresh()
            images = self._rows.frontals(self._records)
            without = {n for i, (n, _, _) in self._records.items() if i not in images}
            if without:
                raise GalleryError(
                    f"{self._db.path}: no frontal image of {len(without)} people, such as "
                    f"{min(without)!r}; enrol them again with the new model, or delete them"
                )
            old, self._records = self._records, {}
            for record, known in old.items():
                new = make(images[record], known[2].assessment)
                self._check(new)
                self._records[record] = self._rows.replace_template(record, known, new)
            _audit.note(self._db, "rebuilt")
            self._remember()
            return len(old)

    def delete(self, subject: str) -> int:
        """Remove all templates of a person without a trace; gives their number."""
        with self._db.transaction(write=True):
            self._refresh()
            person = self._rows.person(subject)
            count = self._rows.delete(person)
            _audit.note(self._db, "deleted", person)
            del self._people[person]
            self._records = {i: r for i, r in self._records.items() if r[0] != subject}
            self._remember()
            return count

    def subjects(self) -> tuple[str, ...]:
        """Who is enrolled, expired consents included, in the order of enrolment."""
        with self._db.transaction():
            self._refresh()
            return tuple(name for name, _ in self._people.values())

    def consent(self, subject: str) -> Consent | None:
        """The ground on which a person is enrolled."""
        with self._db.transaction():
            self._refresh()
            return self._people[self._rows.person(subject)][1]

    def templates(self, subject: str) -> tuple[Template, ...]:
        """Templates of a person, oldest first."""
        with self._db.transaction():
            self._refresh()
            self._rows.person(subject)
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

    # ── between the file and memory ──────────────────────────────────────────────────────

    def _take_up(self) -> None:
        """Check the key, and bring an older version's encryption up to date."""
        with self._db.transaction():
            self._rows.check_key()
            old = self._rows.has_plain_names()
        if old:
            with self._db.transaction(write=True):
                self._rows.seal_names()

    def _refresh(self) -> None:
        """Load what others wrote or removed since the last time, and check the seal."""
        if self._version != self._db.version:
            self._people, self._records = self._rows.read(self._records)
            self._remember()

    def _remember(self) -> None:
        """What is in memory is now what is in the file."""
        self._view, self._version = None, self._db.version

    def _fingerprint(self) -> str | None:
        return next((t.fingerprint for _, _, t in self._records.values()), None)

    def _check(self, template: Template) -> None:
        check_fingerprint(self._fingerprint(), template.fingerprint, str(self._db.path))
        first = next((t for _, _, t in self._records.values()), None)
        check_shape(first, template, str(self._db.path))

    def _put(
        self,
        subject: str,
        template: Template,
        consent: Consent | None,
        frontal: RangeImage | None = None,
    ) -> None:
        check_subject(subject)
        self._check(template)
        person, renewed = self._rows.put_person(subject, consent)
        if renewed:
            _audit.note(self._db, "consent", person)
        if renewed or person not in self._people:
            self._people[person] = subject, consent
        record, known = self._rows.put_template(person, subject, template)
        self._records[record] = known
        _audit.note(self._db, "enrolled", person)
        if frontal is not None:
            self._rows.put_frontal(record, subject, frontal)
