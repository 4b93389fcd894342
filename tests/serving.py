"""A real service in a process of its own, for the tests that ask it over a socket."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass, field
from datetime import datetime
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from rangeface.app.server.keys import KeyRing, Scope

_PROGRAM = """
import json, sys
from pathlib import Path
from rangeface.app.server import Settings
from rangeface.app.server.run import serve
given = json.loads(sys.argv[1])
settings = Settings(keys=Path(given.pop("keys")), **given.pop("settings"))
serve(given["gallery"], None, settings, host="127.0.0.1", port=given["port"],
      tls_certificate=None, tls_key=None)
"""


@dataclass
class Served:
    """A running service on a free port of this computer.

    Parameters
    ----------
    folder : Path
        For its gallery, keys and log.
    settings : dict
        Of `Settings`, but for the keys.
    """

    folder: Path
    settings: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        with closing(socket.socket()) as probe:
            probe.bind(("127.0.0.1", 0))
            self.port: int = probe.getsockname()[1]
        self.keys = KeyRing(self.folder / "test.keys")
        self.key = self.keys.add("all", Scope)
        self.log = self.folder / "service.log"

    def start(self) -> Served:
        """Start it, and wait until it is ready."""
        given = {
            "gallery": str(self.folder / "gallery.db"),
            "keys": str(self.keys.path),
            "port": self.port,
            "settings": self.settings,
        }
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-c", _PROGRAM, json.dumps(given)], stdout=log, stderr=log
            )
        deadline = time.monotonic() + 300.0
        while time.monotonic() < deadline and self.process.poll() is None:
            try:
                if self.ask("GET", "/readyz", key=None)[0] == 200:
                    return self
            except OSError:
                pass
            time.sleep(0.1)
        raise RuntimeError(self.log.read_text())

    def stop(self, sign: int = signal.SIGTERM) -> int:
        """Ask it to stop; gives its exit status."""
        if self.process.poll() is None:
            os.kill(self.process.pid, sign)
        return self.process.wait(timeout=60)

    def new_key(self, *scopes: Scope, expires: datetime | None = None) -> str:
        """Another key."""
        return self.keys.add("test", scopes, expires=expires)

    def connect(self, timeout_s: float = 60.0) -> HTTPConnection:
        """A connection."""
        return HTTPConnection("127.0.0.1", self.port, timeout=timeout_s)

    def ask(
        self, method: str, path: str, body: bytes | Iterable[bytes] | None = None,
        *, key: str | None = "", **query: object,
    ) -> tuple[int, Any]:  # fmt: skip
        """Status and JSON (or text) of an answer; the empty key is that of every scope."""
        status, _, answer = self.ask_headers(method, path, body, key=key, **query)
        return status, answer

    def ask_headers(
        self, method: str, path: str, body: bytes | Iterable[bytes] | None = None,
        *, key: str | None = "", **query: object,
    ) -> tuple[int, dict[str, str], Any]:  # fmt: skip
        """As `ask`, with the headers in between."""
        headers = {} if key is None else {"Authorization": f"Bearer {key or self.key}"}
        with closing(self.connect()) as connection:
            connection.request(method, f"{path}?{urlencode(query)}", body, headers)
            response = connection.getresponse()
            text = response.read().decode()
        kind = response.headers.get_content_type()
        answer = json.loads(text) if kind.endswith("json") else text
        return response.status, {k.lower(): v for k, v in response.headers.items()}, answer
