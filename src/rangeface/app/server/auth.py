"""Who asks, and what they may: a key in every request, ``Authorization: Bearer rf.….…``.

A route says what it needs: ``Annotated[Key, Depends(needs(Scope.IDENTIFY))]``. A browser shows its
key once and then a cookie (`rangeface.app.server.sessions`).
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from typing import Annotated

from fastapi import Depends, Request
from fastapi.security import HTTPBearer
from fastapi.security.http import HTTPAuthorizationCredentials

from rangeface.app.server.keys import Key, Scope
from rangeface.app.server.problems import Cause, RefusalError
from rangeface.app.server.service import Served, Service

#: Why a key may be refused.
KEY_CAUSES = (
    Cause.MISSING_KEY,
    Cause.WRONG_KEY,
    Cause.EXPIRED_KEY,
    Cause.WRONG_SCOPE,
    Cause.TOO_MANY_REQUESTS,
)

_bearer = HTTPBearer(auto_error=False, bearerFormat="rf.ID.SECRET", description="A key.")


def needs(scope: Scope) -> Callable[..., Key]:
    """The dependency of a route that a key must have a scope for."""

    def key(
        request: Request,
        service: Served,
        credentials: Annotated[HTTPAuthorizationCredentials | None, Depends(_bearer)],
    ) -> Key:
        if credentials is None:
            raise RefusalError(Cause.MISSING_KEY)
        found = check(service, credentials.credentials, scope)
        request.state.key = found.id
        return found

    return key


def check(service: Service, text: str, scope: Scope) -> Key:
    """The key of a text, if it is valid, has the scope and is not too fast.

    Raises
    ------
    RefusalError
        It is unknown, expired, without the scope, or too fast.
    """
    key = service.keys.find(text)
    if key is None:
        raise RefusalError(Cause.WRONG_KEY)
    if key.expired(datetime.now(UTC)):
        raise RefusalError(Cause.EXPIRED_KEY)
    if scope not in key.scopes:
        raise RefusalError(Cause.WRONG_SCOPE, f"needs the scope {scope}")
    wait_s = service.rates.wait_s(key.id)
    if wait_s > 0:
        raise RefusalError(Cause.TOO_MANY_REQUESTS, retry_s=wait_s)
    return key
