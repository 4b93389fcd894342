"""The live page: its files, its session, and the WebSocket that carries frames and commands.

The page is let in by an invitation in the fragment of its address (`sessions`), or by a key, and
then holds a cookie that no script can read. The WebSocket needs that cookie and this host's own
Origin. Frames are binary (`rangeface.app.viewing.wire`); at most two are on their way to a page
that has not shown them, a newer one replaces one that waits, and the page is told how many it
missed. Everything else is JSON: ``{"state": …}``, ``{"id": 1, "do": "pause"}``,
``{"reply": 1, "error": null}``, ``{"seen": 17}``.

`create_app` includes `router`; its routes answer where ``app.state`` has a ``stage`` and
``sessions``, which `page_app` and whoever embeds the page sets.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from importlib.resources import files
from typing import Annotated, Any

from fastapi import APIRouter, Depends, FastAPI, Request, Response, WebSocket
from starlette.concurrency import run_in_threadpool
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import HTTPConnection
from starlette.websockets import WebSocketDisconnect

from rangeface.app.server import problems
from rangeface.app.server.auth import check
from rangeface.app.server.keys import Scope
from rangeface.app.server.problems import Cause, RefusalError
from rangeface.app.server.sessions import LIFETIME_S, Session, Sessions
from rangeface.app.viewing.audience import Seat
from rangeface.app.viewing.stage import Stage
from rangeface.errors import RangeFaceError

router = APIRouter(tags=["live"], include_in_schema=False)

_NO_SESSION = 4401  # close codes of ours; the page knows them
_BAD_MESSAGE = 4400
_MOST_CHARACTERS = 2000

_FILES = {
    "page.js": "text/javascript; charset=utf-8",
    "page.css": "text/css; charset=utf-8",
    "page.svg": "image/svg+xml",
}
_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}

#: Command → the scope it needs, and how the stage is asked.
_COMMANDS: Mapping[str, tuple[Scope, Callable[[Stage, Mapping[str, Any]], None]]] = {
    "play": (Scope.ADMIN, lambda stage, _: stage.play()),
    "pause": (Scope.ADMIN, lambda stage, _: stage.pause()),
    "step": (Scope.ADMIN, lambda stage, _: stage.step()),
    "source": (Scope.ADMIN, lambda stage, said: stage.choose(_text(said, "name"))),
    "denoise": (Scope.ADMIN, lambda stage, said: stage.clean(_text(said, "name"))),
    "record": (Scope.ADMIN, lambda stage, said: stage.record(said.get("on") is True)),
    "follow": (Scope.IDENTIFY, lambda stage, said: stage.follow(_integer(said, "track"))),
    "enrol": (
        Scope.ENROLL,
        lambda stage, said: stage.enrol(_text(said, "subject"), _integer(said, "track")),
    ),
    "cancel": (Scope.ENROLL, lambda stage, _: stage.cancel()),
    "save": (Scope.ENROLL, lambda stage, _: stage.save()),
    "delete": (Scope.DELETE, lambda stage, said: stage.delete(_text(said, "subject"))),
}


def page_app(stage: Stage, sessions: Sessions, *, hosts: tuple[str, ...]) -> FastAPI:
    """The page alone, without the service's routes.

    Parameters
    ----------
    stage : Stage
        The caller starts it; it is closed where the application ends.
    sessions : Sessions
    hosts : tuple of str
        Names under which browsers may address it (against DNS rebinding).

    Returns
    -------
    FastAPI
    """

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        yield
        await run_in_threadpool(stage.close)

    app = FastAPI(
        title="rangeface live", docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan
    )
    app.state.stage, app.state.sessions = stage, sessions
    problems.install(app)
    app.include_router(router)
    app.add_middleware(TrustedHostMiddleware, allowed_hosts=list(hosts))
    return app


def _stage(connection: HTTPConnection) -> Stage:
    stage: Stage | None = getattr(connection.app.state, "stage", None)
    if stage is None:
        raise RefusalError(
            Cause.NOT_FOUND, "no camera is shown here; start `rangeface live SOURCE`"
        )
    return stage


Staged = Annotated[Stage, Depends(_stage)]

# ── files ────────────────────────────────────────────────────────────────────────────────────


@router.get("/")
def page(_: Staged) -> Response:
    """The page."""
    return _file("index.html", "text/html; charset=utf-8")


@router.get("/assets/{name}")
def asset(_: Staged, name: str) -> Response:
    """Its script, style and icon."""
    if name not in _FILES:
        raise RefusalError(Cause.NOT_FOUND)
    return _file(f"assets/{name}", _FILES[name])


def _file(name: str, media_type: str) -> Response:
    body = files("rangeface.app").joinpath("page", *name.split("/")).read_bytes()
    return Response(body, media_type=media_type, headers=_HEADERS)


# ── session ──────────────────────────────────────────────────────────────────────────────────


@router.post("/live/session", status_code=204)
async def sign_in(request: Request, _: Staged) -> Response:
    """Turn an invitation, or a key, into a session; both come as ``Authorization: Bearer``."""
    if not _same_origin(request):
        raise RefusalError(Cause.WRONG_SCOPE, "another site's page asks")
    scheme, _blank, text = request.headers.get("authorization", "").partition(" ")
    if scheme.lower() != "bearer" or not text:
        raise RefusalError(Cause.MISSING_KEY)
    sessions: Sessions = request.app.state.sessions
    cookie = sessions.accept(text)
    if cookie is None:
        cookie = _with_key(request, sessions, text)
    response = Response(status_code=204)
    response.set_cookie(
        _cookie_name(request), cookie, max_age=int(LIFETIME_S), httponly=True, samesite="strict",
        secure=request.url.scheme == "https", path="/live",
    )  # fmt: skip
    return response


def _with_key(request: Request, sessions: Sessions, text: str) -> str:
    service = getattr(request.app.state, "service", None)
    if service is None:
        raise RefusalError(Cause.WRONG_KEY)
    return sessions.open(check(service, text, Scope.IDENTIFY).scopes)


def _cookie_name(connection: HTTPConnection) -> str:
    # cookies do not tell ports apart: two pages on one computer must not sign each other out
    return f"rangeface-{connection.url.port or 'page'}"


def _same_origin(connection: HTTPConnection) -> bool:
    origin = connection.headers.get("origin", "")
    return origin.partition("://")[2] == connection.headers.get("host", "")


# ── the WebSocket ────────────────────────────────────────────────────────────────────────────


@router.websocket("/live/socket")
async def socket(websocket: WebSocket) -> None:
    """Frames and states out, commands in, until either side hangs up."""
    await websocket.accept()
    stage: Stage | None = getattr(websocket.app.state, "stage", None)
    session = None if stage is None else _session(websocket)
    if stage is None or session is None or not session.allows(Scope.IDENTIFY):
        await websocket.close(_NO_SESSION)
        return
    seat = Seat()
    seat.tell(await run_in_threadpool(stage.state))
    stage.audience.join(seat)
    sender = asyncio.create_task(_send(websocket, seat))
    try:
        while True:
            await _hear(await websocket.receive_text(), stage, seat, session)
    except (ValueError, ConnectionError):
        await websocket.close(_BAD_MESSAGE)
    except WebSocketDisconnect:
        pass
    finally:
        stage.audience.leave(seat)
        sender.cancel()


def _session(websocket: WebSocket) -> Session | None:
    if not _same_origin(websocket):
        return None
    sessions: Sessions = websocket.app.state.sessions
    return sessions.find(websocket.cookies.get(_cookie_name(websocket)))


async def _send(websocket: WebSocket, seat: Seat) -> None:
    try:
        while True:
            message = await seat.next()
            if isinstance(message, bytes):
                await websocket.send_bytes(message)
            else:
                await websocket.send_text(message)
    except (WebSocketDisconnect, RuntimeError):  # it hung up while we spoke
        pass


async def _hear(text: str, stage: Stage, seat: Seat, session: Session) -> None:
    """Take one message in; ValueError if it is none of ours."""
    if len(text) > _MOST_CHARACTERS:
        raise ValueError("too long a message")
    said = json.loads(text)
    if not isinstance(said, dict):
        raise ValueError("not an object")
    if "seen" in said:
        seat.seen(_integer(said, "seen"))
        return
    number = _integer(said, "id")
    error = await run_in_threadpool(_obey, said, stage, session)
    seat.reply(json.dumps({"reply": number, "error": error}))


def _obey(said: Mapping[str, Any], stage: Stage, session: Session) -> str | None:
    """Carry a command out; what went wrong, in a sentence."""
    name = said.get("do")
    if not isinstance(name, str) or name not in _COMMANDS:
        raise ValueError("no such command")
    scope, ask = _COMMANDS[name]
    if not session.allows(scope):
        return f"This key does not allow that: it needs the scope {scope}"
    try:
        ask(stage, said)
    except (RangeFaceError, OSError) as error:
        return str(error)
    return None


def _text(said: Mapping[str, Any], field: str) -> str:
    value = said.get(field)
    if not isinstance(value, str):
        raise ValueError(f"{field}: need a text")
    return value


def _integer(said: Mapping[str, Any], field: str) -> int:
    value = said.get(field)
    if type(value) is not int:
        raise ValueError(f"{field}: need an integer")
    return value
