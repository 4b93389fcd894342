"""What operators and their tools ask: alive, ready, how much, and open the way again."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Response
from pydantic import BaseModel

import rangeface
from rangeface.app.server import metrics
from rangeface.app.server.auth import needs
from rangeface.app.server.keys import Key, Scope
from rangeface.app.server.problems import Cause, RefusalError, responses
from rangeface.app.server.service import Served, Service
from rangeface.errors import GalleryError

router = APIRouter(tags=["operations"])
open_router = APIRouter(tags=["operations"])


class Health(BaseModel):
    """One word."""

    status: Literal["ok"] = "ok"


class Status(BaseModel):
    """What the service is and holds."""

    version: str
    model: str
    fmr: float
    threshold: float
    people: int
    workers: int
    waiting: int


class Reset(BaseModel):
    """How many keys and names may try again."""

    forgotten: int


@open_router.get("/healthz")
async def healthz() -> Health:
    """Say that the process answers; no key is needed."""
    return Health()


@open_router.get("/readyz", responses=responses(Cause.BUSY, Cause.GALLERY_UNAVAILABLE))
def readyz(service: Served) -> Health:
    """Say whether a scan would be answered; no key is needed."""
    if not service.workers.ready:
        raise RefusalError(Cause.BUSY, "the workers are starting", retry_s=1.0)
    try:
        service.gallery.subjects()
    except GalleryError:
        raise RefusalError(Cause.GALLERY_UNAVAILABLE, retry_s=5.0) from None
    return Health()


@router.get("/v1/status", responses=responses(Cause.GALLERY_UNAVAILABLE))
def status(service: Served, key: Annotated[Key, Depends(needs(Scope.STATUS))]) -> Status:
    """Say what is served."""
    return Status(
        version=rangeface.__version__,
        model=service.recognizer.pipeline.fingerprint,
        fmr=service.settings.fmr,
        threshold=service.recognizer.threshold(service.settings.fmr),
        people=len(service.gallery.subjects()),
        workers=service.workers.ready,
        waiting=service.workers.waiting,
    )


@router.get(
    "/metrics",
    response_class=Response,
    responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}},
)
def numbers(service: Served, key: Annotated[Key, Depends(needs(Scope.STATUS))]) -> Response:
    """Give counters and times for Prometheus."""
    return Response(service.metrics.text(_gauges(service)), media_type=metrics.MEDIA_TYPE)


@router.delete("/v1/attempts")
async def reset(service: Served, key: Annotated[Key, Depends(needs(Scope.ADMIN))]) -> Reset:
    """Let everybody try again who was stopped after too many failures."""
    return Reset(forgotten=service.attempts.reset())


def _gauges(service: Service) -> dict[str, float]:
    return {
        "people": len(service.gallery.subjects()),
        "workers_ready": service.workers.ready,
        "scans_waiting": service.workers.waiting,
    }
