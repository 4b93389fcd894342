"""Under which names the service may be addressed, and from whose pages."""

from __future__ import annotations

from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from rangeface.app.server.problems import Cause, RefusalError


class Hosts:
    """ASGI middleware that refuses other names, and WebSockets that another site's page opens.

    A page of another site can reach a service on this computer through a name that its owner
    points here (DNS rebinding), and open WebSockets to it in any case. The key stops both; this
    stops them before the key is looked at.

    Parameters
    ----------
    app : ASGI application
    names : sequence of str
        Without ports.
    """

    def __init__(self, app: ASGIApp, names: tuple[str, ...]) -> None:
        self._app, self._names = app, frozenset(name.lower() for name in names)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or refuse it."""
        if scope["type"] in ("http", "websocket") and not self._known(scope):
            if scope["type"] == "http":
                await RefusalError(Cause.WRONG_HOST).response()(scope, receive, send)
            else:
                await send({"type": "websocket.close", "code": 1008, "reason": Cause.WRONG_HOST})
            return
        await self._app(scope, receive, send)

    def _known(self, scope: Scope) -> bool:
        headers = Headers(scope=scope)
        host, origin = headers.get("host", ""), headers.get("origin")
        if _name(host) not in self._names:
            return False
        return scope["type"] == "http" or origin is None or urlsplit(origin).netloc == host


def _name(host: str) -> str:
    """A Host header without its port; an IPv6 address keeps its brackets."""
    return host[: host.rfind(":")].lower() if host.rfind(":") > host.rfind("]") else host.lower()
