"""A gallery that lives as long as the process."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from datetime import UTC, date, datetime
from itertools import count
from threading import RLock
from typing import Self

from rangeface.errors import GalleryError
from rangeface.gallery._protocol import (
    AuditEntry,
    Consent,
    NotEnrolledError,
    Record,
    View,
    check_fingerprint,
    check_shape,
    check_subject,
    stack,
)
from rangeface.types import Assessment, RangeImage, Template


class MemoryGallery:
    """Enrolled templates in memory: for tests, demonstrations and short-lived tools.

    Raises
    ------
    GalleryError
        A template of another model or shape is enrolled, a person is unknown, a name is bad.

    Examples
    --------
    >>> gallery = MemoryGallery()
    >>> gallery.enroll("ann", Template(([[1.0, 2.0]],), fingerprint="f"))
    >>> gallery.view().subjects
    ('ann',)
    >>> gallery.delete("ann")
    1
    """

    def __init__(self) -> None:
        self._records: list[tuple[str, Template]] = []
        self._consents: dict[str, Consent | None] = {}
        self._numbers: dict[str, int] = {}
        self._next_number = count(1)
        self._log: list[AuditEntry] = []
        self._view: tuple[date, View] | None = None
        self._lock = RLock()

    @property
    def fingerprint(self) -> str | None:
        """Of the model that made the templates; None where nobody is enrolled."""
        return self._records[0][1].fingerprint if self._records else None

    def enroll(
        self,
        subject: str,
        template: Template,
        *,
        consent: Consent | None = None,
        frontal: RangeImage | None = None,
    ) -> None:
        """Add a template of a person; a new consent replaces the old; no image is kept."""
        if frontal is not None:
            raise GalleryError("memory://: a frontal image is kept only in an encrypted gallery")
        self.enroll_many([(subject, template, consent)])

    def enroll_many(self, records: Iterable[Record]) -> None:
        """Add all of the (subject, template, consent), or none of them."""
        with self._lock:
            batch = list(records)
            first = self._records[0][1] if self._records else None
            for subject, template, _ in batch:
                first = first or template
                check_subject(subject)
                check_fingerprint(first.fingerprint, template.fingerprint, "memory://")
                check_shape(first, template, "memory://")
            for subject, template, consent in batch:
                self._records.append((subject, template))
                self._consents[subject] = consent or self._consents.get(subject)
                self._log.append(AuditEntry(datetime.now(UTC), "enrolled", self._number(subject)))
            self._view = None

    def rebuild(self, make: Callable[[RangeImage, Assessment | None], Template]) -> int:
        """Refuse, unless nobody is enrolled: there are no frontal images."""
        if self._records:
            raise GalleryError("memory://: no frontal image of anybody; enrol again")
        return 0

    def delete(self, subject: str) -> int:
        """Remove all templates of a person; gives their number."""
        with self._lock:
            gone = len(self.templates(subject))
            self._log.append(AuditEntry(datetime.now(UTC), "deleted", self._numbers.pop(subject)))
            self._records = [(s, t) for s, t in self._records if s != subject]
            del self._consents[subject]
            self._view = None
            return gone

    def subjects(self) -> tuple[str, ...]:
        """Who is enrolled, in the order of enrolment."""
        return tuple(self._consents)

    def consent(self, subject: str) -> Consent | None:
        """The ground on which a person is enrolled."""
        self._check_known(subject)
        return self._consents[subject]

    def templates(self, subject: str) -> tuple[Template, ...]:
        """Templates of a person, oldest first."""
        self._check_known(subject)
        return tuple(t for s, t in self._records if s == subject)

    def view(self, *, today: date | None = None) -> View:
        """Everything that may be searched today (default: the computer's date)."""
        day = today or date.today()
        with self._lock:
            if self._view is None or self._view[0] != day:
                searchable = {s for s, c in self._consents.items() if c is None or c.holds(day)}
                kept = [(s, t) for s, t in self._records if s in searchable]
                self._view = day, stack(kept, self.fingerprint)
            return self._view[1]

    def audit(self) -> tuple[AuditEntry, ...]:
        """What was done, oldest first, without names."""
        return tuple(self._log)

    def note(self, action: str) -> None:
        """Append a line of the caller's to the audit log."""
        self._log.append(AuditEntry(datetime.now(UTC), action, 0))

    def close(self) -> None:
        """Forget everybody."""
        self._records, self._consents, self._view = [], {}, None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()

    def _number(self, subject: str) -> int:
        if subject not in self._numbers:
            self._numbers[subject] = next(self._next_number)
        return self._numbers[subject]

    def _check_known(self, subject: str) -> None:
        if subject not in self._consents:
            raise NotEnrolledError(f"memory://: {subject!r} is not enrolled")
