"""Who is this, and is it who it claims to be?"""

from __future__ import annotations

import math
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from pydantic import BaseModel, Field
from starlette.concurrency import run_in_threadpool

from rangeface.app.server import scans
from rangeface.app.server.auth import needs
from rangeface.app.server.keys import Key, Scope
from rangeface.app.server.problems import Cause, RefusalError, responses
from rangeface.app.server.service import Served, Service
from rangeface.app.server.workers import Seen
from rangeface.decide import refuse
from rangeface.decide import verify as decide_claim
from rangeface.gallery import View
from rangeface.types import Decision, Reason, Template, Verdict

router = APIRouter(prefix="/v1", tags=["decisions"])

Subject = Annotated[str, Query(min_length=1, max_length=200, description="A person's name.")]
_LOCKS = (Cause.TOO_MANY_FAILURES, Cause.ATTEMPTS_STOPPED)


class Candidate(BaseModel):
    """A person and a score."""

    subject: str
    score: float


class Answer(BaseModel):
    """A decision; scores only for a key with the scope *scores*."""

    verdict: Verdict
    subject: str | None = Field(description="Who was recognised; null unless accepted.")
    reason: Reason | None = Field(description="Why it was not accepted.")
    score: float | None = None
    threshold: float | None = None
    ranking: list[Candidate] | None = None


@router.post(
    "/identify",
    openapi_extra=scans.BODY,
    responses=responses(*scans.CAUSES, *_LOCKS, Cause.OTHER_MODEL, Cause.GALLERY_UNAVAILABLE),
)
async def identify(
    request: Request,
    service: Served,
    key: Annotated[Key, Depends(needs(Scope.IDENTIFY))],
    scan: scans.Scan,
) -> Answer:
    """Say who a scan shows, of those who are enrolled: accepted, unknown, or cannot tell."""
    body, order = await scans.receive(request, service, scan)
    async with service.attempts.attempt(f"key {key.id}") as attempt:
        seen = await service.workers.see(body, order)
        decision = await run_in_threadpool(_who, service, seen)
        attempt.failed = _failed(decision)
    service.metrics.decision("identify", decision.verdict)
    return _answer(decision, key)


@router.post(
    "/verify",
    openapi_extra=scans.BODY,
    responses=responses(
        *scans.CAUSES, *_LOCKS, Cause.NOT_ENROLLED, Cause.OTHER_MODEL, Cause.GALLERY_UNAVAILABLE
    ),
)
async def verify(
    request: Request,
    service: Served,
    key: Annotated[Key, Depends(needs(Scope.VERIFY))],
    subject: Subject,
    scan: scans.Scan,
) -> Answer:
    """Say whether a scan shows the person it claims to."""
    body, order = await scans.receive(request, service, scan)
    async with service.attempts.attempt(f"subject {subject}") as attempt:
        seen = await service.workers.see(body, order)
        decision = await run_in_threadpool(_claimed, service, seen, subject)
        attempt.failed = _failed(decision)
    service.metrics.decision("verify", decision.verdict)
    return _answer(decision, key)


def view(service: Service) -> View:
    """What may be searched now, which must come from the served model.

    Raises
    ------
    RefusalError
        It does not.
    """
    found = service.gallery.view()
    if found.fingerprint not in (None, service.recognizer.pipeline.fingerprint):
        raise RefusalError(Cause.OTHER_MODEL, "use the model that enrolled, or rebuild the gallery")
    return found


def _who(service: Service, seen: Seen) -> Decision:
    threshold = service.recognizer.threshold(service.settings.fmr)
    if seen.template is None:
        return refuse(seen.reason or Reason.NO_FACE, threshold=threshold)
    found = view(service)
    scores = service.recognizer.scores(seen.template, found)
    return service.recognizer.pipeline.decide_on(
        dict(zip(found.subjects, scores.tolist(), strict=True)),
        seen.template.assessment,
        threshold,
    )


def _claimed(service: Service, seen: Seen, subject: str) -> Decision:
    threshold = service.recognizer.threshold(service.settings.fmr)
    found = view(service)
    if subject not in found.subjects:
        raise RefusalError(Cause.NOT_ENROLLED)
    if seen.template is None:
        return refuse(seen.reason or Reason.NO_FACE, threshold=threshold)
    score = _score(service, seen.template, found, subject)
    return decide_claim(score, subject, seen.template.assessment, threshold=threshold)


def _score(service: Service, probe: Template, found: View, subject: str) -> float:
    return float(service.recognizer.scores(probe, found)[found.subjects.index(subject)])


def _failed(decision: Decision) -> bool | None:
    """Whether an attempt failed; None where nothing was compared."""
    if decision.verdict is Verdict.CANNOT_TELL and decision.reason is not Reason.AMBIGUOUS:
        return None
    return decision.verdict is not Verdict.ACCEPTED


def _answer(decision: Decision, key: Key) -> Answer:
    answer = Answer(verdict=decision.verdict, subject=decision.subject, reason=decision.reason)
    if Scope.SCORES in key.scopes:
        answer.score = _finite(decision.score)
        answer.threshold = _finite(decision.threshold)
        answer.ranking = [Candidate(subject=s, score=v) for s, v in decision.ranking]
    return answer


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
