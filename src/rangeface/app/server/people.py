"""Enrol, list, delete; and what was done."""

from __future__ import annotations

from datetime import date, datetime
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from pydantic import BaseModel
from starlette.concurrency import run_in_threadpool

from rangeface.app.server import scans
from rangeface.app.server.auth import needs
from rangeface.app.server.decisions import Subject, view
from rangeface.app.server.keys import Key, Scope
from rangeface.app.server.problems import Cause, RefusalError, responses
from rangeface.app.server.service import Served, Service
from rangeface.app.server.workers import Seen
from rangeface.gallery import Consent, NotEnrolledError

router = APIRouter(prefix="/v1", tags=["people"])


class Enrolled(BaseModel):
    """Who was enrolled, and how many people there are now."""

    subject: str
    people: int


class Deleted(BaseModel):
    """Who was deleted, with how many templates."""

    subject: str
    templates: int


class Person(BaseModel):
    """Somebody who is enrolled."""

    subject: str
    consent: str | None
    expires: date | None


class People(BaseModel):
    """A page of the list."""

    total: int
    people: list[Person]


class AuditLine(BaseModel):
    """A line of the audit log: a person is a number that is never used again."""

    at: datetime
    action: str
    person: int


@router.post(
    "/people",
    status_code=201,
    openapi_extra=scans.BODY,
    responses=responses(*scans.CAUSES, Cause.NO_FACE, Cause.OTHER_MODEL, Cause.GALLERY_UNAVAILABLE),
)
async def enroll(
    request: Request,
    service: Served,
    key: Annotated[Key, Depends(needs(Scope.ENROLL))],
    subject: Subject,
    scan: scans.Scan,
    consent: Annotated[
        str | None, Query(min_length=1, max_length=200, description="Reference of the consent.")
    ] = None,
    expires: Annotated[date | None, Query(description="Last day of the consent.")] = None,
) -> Enrolled:
    """Enrol a person, or add a template; the answer comes when it is safe on the disk."""
    ground = _ground(consent, expires)
    if not subject.isprintable():
        raise RefusalError(Cause.BAD_PARAMETER, "subject: need printable characters")
    seen = await service.workers.see(*await scans.receive(request, service, scan, augment=True))
    if seen.template is None:
        raise RefusalError(Cause.NO_FACE, why=seen.reason)
    assessment = seen.template.assessment
    if assessment is not None and not assessment.usable:
        raise RefusalError(
            Cause.NO_FACE, ", ".join(assessment.refusals), why=assessment.refusals[0]
        )
    count = await run_in_threadpool(_put, service, subject, seen, ground)
    return Enrolled(subject=subject, people=count)


@router.get("/people", responses=responses(Cause.GALLERY_UNAVAILABLE))
def people(
    service: Served,
    key: Annotated[Key, Depends(needs(Scope.LIST))],
    offset: Annotated[int, Query(ge=0, le=1 << 31)] = 0,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
) -> People:
    """List who is enrolled, in the order of enrolment."""
    names = service.gallery.subjects()
    page = [_person(service, name) for name in names[offset : offset + limit]]
    return People(total=len(names), people=[person for person in page if person is not None])


@router.delete("/people", responses=responses(Cause.NOT_ENROLLED, Cause.GALLERY_UNAVAILABLE))
def delete(
    service: Served, key: Annotated[Key, Depends(needs(Scope.DELETE))], subject: Subject
) -> Deleted:
    """Delete a person; no part of the templates is left in the gallery's file."""
    try:
        return Deleted(subject=subject, templates=service.gallery.delete(subject))
    except NotEnrolledError:
        raise RefusalError(Cause.NOT_ENROLLED) from None


@router.get("/audit", responses=responses(Cause.GALLERY_UNAVAILABLE))
def audit(
    service: Served,
    key: Annotated[Key, Depends(needs(Scope.ADMIN))],
    limit: Annotated[int, Query(ge=1, le=10_000)] = 1000,
) -> list[AuditLine]:
    """Give the last lines of the audit log, oldest first."""
    lines = service.gallery.audit()[-limit:]
    return [AuditLine(at=line.at, action=line.action, person=line.person) for line in lines]


def _ground(reference: str | None, expires: date | None) -> Consent | None:
    if reference is None:
        if expires is not None:
            raise RefusalError(Cause.BAD_PARAMETER, "expires: of which consent?")
        return None
    return Consent(reference, expires)


def _put(service: Service, subject: str, seen: Seen, ground: Consent | None) -> int:
    view(service)
    assert seen.template is not None
    service.gallery.enroll(subject, seen.template, consent=ground, frontal=seen.frontal)
    return len(service.gallery.subjects())


def _person(service: Service, name: str) -> Person | None:
    try:
        consent = service.gallery.consent(name)
    except NotEnrolledError:  # deleted since the list was made
        return None
    reference, expires = (consent.reference, consent.expires) if consent else (None, None)
    return Person(subject=name, consent=reference, expires=expires)
