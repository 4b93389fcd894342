"""Every way to say no: RFC 9457 problems with a closed list of reasons."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from enum import StrEnum
from http import HTTPStatus
from typing import Any, Literal

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException

from rangeface.errors import GalleryError

_log = logging.getLogger("rangeface.service")

MEDIA_TYPE = "application/problem+json"


class Cause(StrEnum):
    """The closed list of reasons for which the service refuses a request."""

    MISSING_KEY = "missing-key"
    WRONG_KEY = "wrong-key"
    EXPIRED_KEY = "expired-key"
    WRONG_SCOPE = "wrong-scope"
    TOO_MANY_REQUESTS = "too-many-requests"
    TOO_MANY_FAILURES = "too-many-failures"
    ATTEMPTS_STOPPED = "attempts-stopped"
    WRONG_HOST = "wrong-host"
    BAD_PARAMETER = "bad-parameter"
    BODY_TOO_LARGE = "body-too-large"
    BODY_TOO_SLOW = "body-too-slow"
    SCAN_REFUSED = "scan-refused"
    SCAN_TOO_SLOW = "scan-too-slow"
    NO_FACE = "no-face"
    NOT_ENROLLED = "not-enrolled"
    NOT_FOUND = "not-found"
    METHOD_NOT_ALLOWED = "method-not-allowed"
    OTHER_MODEL = "other-model"
    GALLERY_UNAVAILABLE = "gallery-unavailable"
    BUSY = "busy"
    INTERNAL = "internal-error"


_TABLE: Mapping[Cause, tuple[int, str]] = {
    Cause.MISSING_KEY: (401, "a key is needed: Authorization: Bearer …"),
    Cause.WRONG_KEY: (401, "the key is unknown"),
    Cause.EXPIRED_KEY: (401, "the key has expired"),
    Cause.WRONG_SCOPE: (403, "the key does not have this scope"),
    Cause.TOO_MANY_REQUESTS: (429, "too many requests"),
    Cause.TOO_MANY_FAILURES: (429, "too many failed attempts in a row"),
    Cause.ATTEMPTS_STOPPED: (403, "stopped after too many failed attempts"),
    Cause.WRONG_HOST: (421, "not served under this name"),
    Cause.BAD_PARAMETER: (422, "a parameter is missing or out of range"),
    Cause.BODY_TOO_LARGE: (413, "the scan is too large"),
    Cause.BODY_TOO_SLOW: (408, "the scan did not arrive in time"),
    Cause.SCAN_REFUSED: (422, "the scan cannot be read"),
    Cause.SCAN_TOO_SLOW: (422, "the scan takes too long"),
    Cause.NO_FACE: (422, "the scan shows no face fit for enrolment"),
    Cause.NOT_ENROLLED: (404, "nobody of this name is enrolled"),
    Cause.NOT_FOUND: (404, "there is nothing here"),
    Cause.METHOD_NOT_ALLOWED: (405, "not with this method"),
    Cause.OTHER_MODEL: (409, "the gallery was made with another model"),
    Cause.GALLERY_UNAVAILABLE: (503, "the gallery cannot be used"),
    Cause.BUSY: (503, "busy; try again"),
    Cause.INTERNAL: (500, "an error of the service; its log has the details"),
}


class Problem(BaseModel):
    """RFC 9457 problem details."""

    type: str = Field(examples=["urn:rangeface:problem:missing-key"])
    title: str
    status: int
    detail: str = ""
    reason: Cause
    why: str | None = Field(default=None, description="The scan's fault, or the face's.")


class RefusalError(Exception):
    """What a route raises to say no.

    Parameters
    ----------
    cause : Cause
        Reason from the closed list.
    detail : str
        This case, in a sentence; never a secret.
    why : str, optional
        Of a scan: its `ScanFault`; of a face: its `Reason`.
    retry_s : float, optional
        When to try again, s.
    """

    def __init__(
        self,
        cause: Cause,
        detail: str = "",
        *,
        why: str | None = None,
        retry_s: float | None = None,
    ) -> None:
        super().__init__(cause, detail)
        self.cause, self.detail, self.why, self.retry_s = cause, detail, why, retry_s

    @property
    def status(self) -> int:
        """HTTP status."""
        return _TABLE[self.cause][0]

    def response(self) -> JSONResponse:
        """The problem as a response."""
        status, title = _TABLE[self.cause]
        problem = Problem(
            type=f"urn:rangeface:problem:{self.cause}", title=title, status=status,
            detail=self.detail, reason=self.cause, why=self.why,
        )  # fmt: skip
        headers = {}
        if status == HTTPStatus.UNAUTHORIZED:
            headers["WWW-Authenticate"] = 'Bearer realm="rangeface"'
        if status in (HTTPStatus.REQUEST_ENTITY_TOO_LARGE, HTTPStatus.REQUEST_TIMEOUT):
            headers["Connection"] = "close"  # what is left of the body is not worth reading
        if self.retry_s is not None:
            headers["Retry-After"] = str(max(1, round(self.retry_s)))
        return JSONResponse(
            problem.model_dump(mode="json", exclude_none=True), status,
            media_type=MEDIA_TYPE, headers=headers,
        )  # fmt: skip


def responses(*causes: Cause) -> dict[int | str, dict[str, Any]]:
    """The OpenAPI entries of the problems that a route can answer with."""
    by_status: dict[int | str, dict[str, Any]] = {}
    for cause in causes:
        status, title = _TABLE[cause]
        entry = by_status.setdefault(
            status,
            {
                "description": "",
                "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}},
            },
        )
        entry["description"] = "; ".join(filter(None, (entry["description"], f"{cause}: {title}")))
    return by_status


def install(app: FastAPI) -> None:
    """Make the application answer every failure with a problem."""
    app.add_exception_handler(RefusalError, _refused)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(GalleryError, _gallery)
    app.add_exception_handler(Exception, _broken)
    described = app.openapi

    def openapi() -> dict[str, Any]:
        document = described()
        schema = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
        schemas = document.setdefault("components", {}).setdefault("schemas", {})
        schemas |= {**schema.pop("$defs"), "Problem": schema}
        return document

    app.openapi = openapi  # type: ignore[method-assign]


async def _refused(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RefusalError)
    return error.response()


async def _invalid(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    lines = (f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in error.errors())
    return RefusalError(Cause.BAD_PARAMETER, "; ".join(lines)).response()


async def _http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    known: Mapping[int, Literal[Cause.NOT_FOUND, Cause.METHOD_NOT_ALLOWED]] = {
        404: Cause.NOT_FOUND,
        405: Cause.METHOD_NOT_ALLOWED,
    }
    response = RefusalError(known.get(error.status_code, Cause.BAD_PARAMETER)).response()
    response.headers.update(error.headers or {})
    described = request.app.openapi()["paths"].get(request.url.path)
    if error.status_code == HTTPStatus.METHOD_NOT_ALLOWED and described:
        response.headers["Allow"] = ", ".join(sorted(map(str.upper, described)))
    return response


async def _gallery(_: Request, error: Exception) -> JSONResponse:
    _log.error("%s", error)
    detail = str(error).partition(": ")[2]  # what is wrong, without the path of the file
    return RefusalError(Cause.GALLERY_UNAVAILABLE, detail, retry_s=5.0).response()


async def _broken(_: Request, error: Exception) -> JSONResponse:
    return RefusalError(Cause.INTERNAL, type(error).__name__).response()
