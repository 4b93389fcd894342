"""What all routes share: one frozen value, kept in `app.state`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends
from starlette.requests import HTTPConnection

from rangeface.app.server.attempts import Attempts
from rangeface.app.server.keys import KeyRing
from rangeface.app.server.metrics import Metrics
from rangeface.app.server.rates import Rates
from rangeface.app.server.settings import Settings
from rangeface.app.server.workers import Workers
from rangeface.gallery import Gallery
from rangeface.recognizer import FaceRecognizer


@dataclass(frozen=True, eq=False)
class Service:
    """The parts of a running service.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Calibrated.
    gallery : Gallery
        Of the same model, or empty.
    settings : Settings
    keys : KeyRing
    attempts : Attempts
    rates : Rates
    workers : Workers
    metrics : Metrics
    """

    recognizer: FaceRecognizer
    gallery: Gallery
    settings: Settings
    keys: KeyRing
    attempts: Attempts
    rates: Rates
    workers: Workers
    metrics: Metrics


def _service(connection: HTTPConnection) -> Service:
    service: Service = connection.app.state.service
    return service


#: Parameter of a route that needs the service.
Served = Annotated[Service, Depends(_service)]
