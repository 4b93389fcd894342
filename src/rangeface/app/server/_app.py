"""The application, put together."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI
from starlette.concurrency import run_in_threadpool

import rangeface
from rangeface.app.server import decisions, live, operations, people, problems
from rangeface.app.server.attempts import Attempts
from rangeface.app.server.auth import KEY_CAUSES
from rangeface.app.server.hosts import Hosts
from rangeface.app.server.keys import KeyRing
from rangeface.app.server.metrics import Metrics
from rangeface.app.server.problems import Cause, responses
from rangeface.app.server.rates import Rates
from rangeface.app.server.requests import Requests
from rangeface.app.server.service import Service
from rangeface.app.server.settings import Settings
from rangeface.app.server.workers import Workers
from rangeface.gallery import Gallery, check_fingerprint
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Template


def create_app(recognizer: FaceRecognizer, gallery: Gallery, settings: Settings) -> FastAPI:
    """The service as an ASGI application.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Calibrated, so that a false match rate has a threshold.
    gallery : Gallery
        Of the same model, or empty; the caller closes it.
    settings : Settings

    Returns
    -------
    FastAPI
        Its parts are in ``app.state.service``.

    Raises
    ------
    ParameterError
        The recogniser is not calibrated for the false match rate.
    GalleryError
        The gallery was made with another model.
    """
    recognizer.threshold(settings.fmr)
    check_fingerprint(gallery.fingerprint, recognizer.pipeline.fingerprint, "gallery")
    service = Service(
        recognizer, gallery, settings, KeyRing(settings.keys),
        Attempts(settings.failures, settings.pause_s, settings.stop),
        Rates(settings.requests_per_s, settings.burst),
        Workers(count=settings.workers, queue=settings.queue, seconds=settings.scan_s),
        Metrics(),
    )  # fmt: skip
    app = FastAPI(
        title="rangeface",
        version=rangeface.__version__,
        description="Recognises faces in range images. Every route but /healthz and /readyz "
        "needs a key.",
        docs_url=None,
        redoc_url=None,
        lifespan=_lifespan,
    )
    app.state.service = service
    problems.install(app)
    for router in (decisions.router, people.router, operations.router):
        app.include_router(router, responses=responses(*KEY_CAUSES, Cause.BAD_PARAMETER))
    app.include_router(operations.open_router)
    app.include_router(live.router)
    app.add_middleware(Hosts, names=settings.hosts)
    app.add_middleware(Requests, metrics=service.metrics)
    return app


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    service: Service = app.state.service
    await service.workers.start(service.recognizer)
    try:
        await run_in_threadpool(_warm_up, service)
        yield
    finally:
        await service.workers.stop()


def _warm_up(service: Service) -> None:
    """Load the gallery and compile the search, so that the first answer is as fast as others."""
    service.gallery.view()
    cohort = service.recognizer.cohort
    if cohort is not None:
        probe = Template(tuple(v[:1] for v in cohort.vectors), str(cohort.fingerprint))
        service.recognizer.scores(probe, cohort)
