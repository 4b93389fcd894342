"""Starts the page: the stage, the invitation, the server, and a clean stop."""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping
from pathlib import Path

import uvicorn

from rangeface.app.console import console
from rangeface.app.models import load_model
from rangeface.app.server.live import page_app
from rangeface.app.server.sessions import Sessions
from rangeface.app.viewing import scenes
from rangeface.app.viewing.stage import Stage
from rangeface.gallery import Gallery, check_fingerprint, open_gallery
from rangeface.recognizer import FaceRecognizer
from rangeface.sources import Reconnecting, Source, open_source

_HOST = "127.0.0.1"
_DEVICES = ("realsense:", "orbbec:")
_STOP_S = 3
_MOST_MESSAGE_BYTES = 8192


def live(
    source: str, gallery: str, model: Path | None, *, fmr: float, port: int, recordings: Path
) -> None:
    """Show a source, and the synthetic camera for comparison."""
    recognizer = load_model(model)
    offered = {source: source, "synthetic:sr3000": "Synthetic SR-3000"}
    with open_gallery(gallery) as opened:
        check_fingerprint(opened.fingerprint, recognizer.pipeline.fingerprint, gallery)
        if gallery.startswith("memory:"):
            console.print("people are kept in memory only; --gallery FILE keeps them")
        _serve(recognizer, opened, open_source, offered, fmr=fmr, port=port, recordings=recordings)


def demo(*, port: int, recordings: Path) -> None:
    """Show the synthetic camera; six people who do not exist are enrolled."""
    recognizer = load_model(None)
    offered = {address: label for address, (label, _) in scenes.SCENES.items()}
    with scenes.friends(recognizer) as gallery:
        _serve(
            recognizer, gallery, scenes.open_scene, offered,
            fmr=0.001, port=port, recordings=recordings,
        )  # fmt: skip


def _open(address: str) -> Source:
    """A source; a device that is unplugged is opened again when it is back."""
    if not address.startswith(_DEVICES):
        return open_source(address)
    open_source(address).close()  # what is wrong from the start is said at once
    return Reconnecting(lambda: open_source(address))


def _serve(
    recognizer: FaceRecognizer,
    gallery: Gallery,
    opener: Callable[[str], Source],
    offered: Mapping[str, str],
    *,
    fmr: float,
    port: int,
    recordings: Path,
) -> None:
    recognizer.threshold(fmr)  # a model without thresholds is refused here, in one line
    stage = Stage(
        recognizer, gallery, opener=opener, sources=offered, recordings=recordings, fmr=fmr
    )
    sessions = Sessions()
    with socket.create_server((_HOST, port)) as listening:
        port = listening.getsockname()[1]
        stage.choose(next(iter(offered)))
        address = f"http://{_HOST}:{port}/#{sessions.invite()}"
        console.print(f"open {address}", soft_wrap=True, markup=False, highlight=False)
        console.print("the address is good for one browser; Ctrl+C ends", highlight=False)
        config = uvicorn.Config(
            page_app(stage, sessions, hosts=(_HOST, "localhost")),
            ws="websockets-sansio",
            ws_max_size=_MOST_MESSAGE_BYTES,
            ws_per_message_deflate=False,  # a frame is mostly noise, and this host is near
            log_config=None,
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=_STOP_S,
        )
        uvicorn.Server(config).run(sockets=[listening])
