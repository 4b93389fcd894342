"""`rangeface serve`: the first key, the address, TLS, and a clean stop."""

from __future__ import annotations

import ipaddress
import logging
import signal
from dataclasses import replace
from pathlib import Path

import uvicorn

from rangeface.app.console import console
from rangeface.app.models import load_model
from rangeface.app.server._app import create_app
from rangeface.app.server.connections import within
from rangeface.app.server.keys import KeyRing, Scope, write_private
from rangeface.app.server.settings import Settings
from rangeface.errors import ParameterError
from rangeface.gallery import KEY_VARIABLE, open_gallery, read_key

_STOP_S = 20


def serve(
    gallery: str,
    model: Path | None,
    settings: Settings,
    *,
    host: str,
    port: int,
    tls_certificate: Path | None,
    tls_key: Path | None,
) -> None:
    """Serve until SIGTERM or SIGINT; requests on their way are answered first."""
    check_address(host, tls_certificate, tls_key)
    if settings.keep_frontal and read_key() is None:
        raise ParameterError(f"keep_frontal: needs an encrypted gallery; set {KEY_VARIABLE}")
    settings = replace(settings, hosts=(*settings.hosts, host))
    first = first_key(settings.keys)
    if first is not None:
        console.print(f"key: {first}", markup=False, highlight=False)
    logging.basicConfig(format="%(asctime)s %(name)s %(message)s", level=logging.WARNING)
    logging.getLogger("rangeface.service").setLevel(logging.INFO)
    with open_gallery(gallery) as opened:
        app = create_app(load_model(model), opened, settings)
        scheme = "http" if tls_certificate is None else "https"
        # uvicorn raises again what stopped it, which would end the process before it has cleaned up
        signal.signal(signal.SIGTERM, lambda *_: None)
        console.print(f"serving {scheme}://{host}:{port}", markup=False, highlight=False)
        uvicorn.run(
            app,
            host=host,
            port=port,
            http=within(settings.header_s),
            ws="websockets-sansio",
            log_config=None,
            access_log=False,
            server_header=False,
            limit_concurrency=settings.max_connections,
            timeout_keep_alive=30,
            timeout_graceful_shutdown=_STOP_S,
            h11_max_incomplete_event_size=1 << 15,
            ssl_certfile=tls_certificate,
            ssl_keyfile=tls_key,
        )


def check_address(host: str, tls_certificate: Path | None, tls_key: Path | None) -> None:
    """Refuse to listen beyond this computer without TLS.

    Raises
    ------
    ParameterError
        The address is public and there is no TLS, or only half of it.
    """
    if (tls_certificate is None) != (tls_key is None):
        raise ParameterError("tls: give the certificate and its key")
    if tls_certificate is None and not _loopback(host):
        raise ParameterError(
            f"host: {host} is reached from outside; give --tls-certificate and --tls-key, "
            "or listen on 127.0.0.1"
        )


def first_key(path: Path) -> Path | None:
    """Make a key of every scope where there is no file of keys yet; gives the file it is in."""
    if path.exists():
        return None
    text = KeyRing(path).add("first", Scope)
    place = path.with_suffix(".key")
    write_private(place, text + "\n")
    return place


def _loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
