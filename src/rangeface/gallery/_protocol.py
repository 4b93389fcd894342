"""What every gallery can do, whatever engine keeps it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import date, datetime
from typing import Protocol, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import GalleryError
from rangeface.types import Assessment, RangeImage, Template


class NotEnrolledError(GalleryError):
    """Nobody of this name is enrolled."""


@dataclass(frozen=True)
class Consent:
    """On what ground a person is enrolled, and until when.

    Parameters
    ----------
    reference : str
        Number or address of the document; the document itself is not kept here.
    expires : date, optional
        Last day on which the person may be searched for; None: until deleted.
    """

    reference: str
    expires: date | None = None

    def holds(self, today: date) -> bool:
        """Whether the consent has not expired."""
        return self.expires is None or today <= self.expires


Record: TypeAlias = "tuple[str, Template, Consent | None]"


@dataclass(frozen=True)
class AuditEntry:
    """One line of the audit log.

    Parameters
    ----------
    at : datetime
        When, UTC.
    action : str
        "enrolled", "consent", "deleted", "rebuilt", "exported", "imported", "backed up", or the
        caller's.
    person : int
        The person's number in this gallery, never used again; 0 where all are meant. After a
        deletion nothing tells who it was.
    """

    at: datetime
    action: str
    person: int


@dataclass(frozen=True, eq=False)
class View:
    """All enrolled templates as one array a head, ready to be searched without a copy.

    Parameters
    ----------
    subjects : tuple of str
        Who is enrolled, in the order of enrolment.
    owners : tuple of (rows,) int arrays
        For each head, the number in `subjects` that each row belongs to.
    vectors : tuple of (rows, D) float32 arrays
        For each head, every view of every template.
    fingerprint : str or None
        Of the model that made them; None where nobody is enrolled.
    """

    subjects: tuple[str, ...]
    owners: tuple[NDArray[np.intp], ...]
    vectors: tuple[NDArray[np.float32], ...]
    fingerprint: str | None


class Gallery(Protocol):
    """Enrolled templates: enrol, delete, list, search.

    An operation that returned is durable, and every process sees it in its next `view`. All
    templates of a gallery come from one model: `fingerprint` names it.
    """

    @property
    def fingerprint(self) -> str | None:
        """Of the model that made the templates; None where nobody is enrolled."""

    def enroll(
        self,
        subject: str,
        template: Template,
        *,
        consent: Consent | None = None,
        frontal: RangeImage | None = None,
    ) -> None:
        """Add a template of a person, who may have several; a new consent replaces the old.

        The frontal image, if one is given, is kept for `rebuild`: only where it can be sealed.
        """

    def enroll_many(self, records: Iterable[Record]) -> None:
        """Add all of the (subject, template, consent), or none of them."""

    def rebuild(self, make: Callable[[RangeImage, Assessment | None], Template]) -> int:
        """Make every template anew from its frontal image, for another model; all or none."""

    def delete(self, subject: str) -> int:
        """Remove all templates of a person without a trace; gives their number."""

    def subjects(self) -> tuple[str, ...]:
        """Who is enrolled, expired consents included, in the order of enrolment."""

    def consent(self, subject: str) -> Consent | None:
        """The ground on which a person is enrolled."""

    def templates(self, subject: str) -> tuple[Template, ...]:
        """Templates of a person, oldest first."""

    def view(self, *, today: date | None = None) -> View:
        """Everything that may be searched today (default: the computer's date)."""

    def audit(self) -> tuple[AuditEntry, ...]:
        """What was done, oldest first, without names."""

    def note(self, action: str) -> None:
        """Append a line of the caller's to the audit log."""

    def close(self) -> None:
        """Let go of files and memory."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *failure: object) -> None: ...


def check_fingerprint(kept: str | None, offered: str, place: str) -> None:
    """Refuse a template or model whose fingerprint is not the gallery's.

    Raises
    ------
    GalleryError
        They differ; the message names the way out.
    """
    if kept is not None and kept != offered:
        raise GalleryError(
            f"{place}: enrolled with model {kept[:12]}, asked with model {offered[:12]}; "
            "use the first model, rebuild the gallery, or enrol everybody again with the second"
        )


def check_shape(kept: Template | None, offered: Template, place: str) -> None:
    """Refuse a template that cannot stand in one array with those that are enrolled.

    Raises
    ------
    GalleryError
        It has no vectors, or other heads or lengths than the gallery's.
    """
    widths = [v.shape[1:] for v in offered.vectors]
    shaped = all(v.ndim == 2 and v.shape[1] > 0 for v in offered.vectors)
    if not shaped or not any(len(v) for v in offered.vectors):
        raise GalleryError(
            f"{place}: a template needs (k, D) vectors for each head, and k ≥ 1 for some"
        )
    if not all(np.isfinite(v).all() for v in offered.vectors):
        raise GalleryError(f"{place}: a template must be finite")
    if kept is not None and widths != [v.shape[1:] for v in kept.vectors]:
        raise GalleryError(f"{place}: a template of {widths} does not fit those enrolled")


def check_subject(subject: str) -> str:
    """A person's name, which must not be empty and must be printable.

    Raises
    ------
    GalleryError
        It is not.
    """
    if not subject or not subject.isprintable() or len(subject) > 200:
        raise GalleryError(f"subject: need 1 … 200 printable characters, got {subject[:40]!r}")
    return subject


def stack(records: Iterable[tuple[str, Template]], fingerprint: str | None) -> View:
    """The view of (subject, template) pairs."""
    pairs = list(records)
    subjects = tuple(dict.fromkeys(subject for subject, _ in pairs))
    number = {subject: i for i, subject in enumerate(subjects)}
    heads = range(len(pairs[0][1].vectors)) if pairs else range(0)
    owners = tuple(
        np.repeat([number[s] for s, _ in pairs], [len(t.vectors[h]) for _, t in pairs])
        for h in heads
    )
    vectors = tuple(np.concatenate([t.vectors[h] for _, t in pairs]) for h in heads)
    for array in (*owners, *vectors):
        array.flags.writeable = False
    return View(subjects, owners, vectors, fingerprint if pairs else None)
