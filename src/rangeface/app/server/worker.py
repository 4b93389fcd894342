"""A process that turns a scan into a template, so that no hostile file is read beside the gallery.

Run as ``python -m rangeface.app.server.worker MODEL``. It reads orders from standard input and
writes answers to standard output, as `messages` packs them.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any, BinaryIO

import cv2

from rangeface.app.server.messages import HEAD_BYTES, lengths, pack
from rangeface.app.server.orders import order_from
from rangeface.errors import ParameterError, ScanError
from rangeface.gallery import frontal_to_bytes, template_to_bytes
from rangeface.recognizer import FaceRecognizer

_MEMORY = 1 << 30


def main() -> None:
    """Answer orders until standard input ends."""
    inbox, outbox = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a library prints must not look like an answer
    answer = _Reader(sys.argv[1])
    answer.warm_up()
    _limit()
    _send(outbox, pack({"kind": "ready"}))
    while head := inbox.read(HEAD_BYTES):
        text, body = lengths(head)
        _send(outbox, answer(json.loads(inbox.read(text)), inbox.read(body)))


class _Reader:
    """Model and readers, loaded once."""

    def __init__(self, model: str) -> None:
        cv2.setNumThreads(1)
        self._recognizer = FaceRecognizer.load(model)

    def warm_up(self) -> None:
        """See a face and things that are none, so that all is compiled before the first scan."""
        image = self._recognizer.pipeline.reference.image
        for depth in (400.0 + image.depth, 400.0 - image.depth, 100.0 * (400.0 + image.depth)):
            trace = self._recognizer.pipeline.trace(image.with_depth(depth))
            if trace.frontal is not None:
                self._recognizer.template(trace, augment=True)

    def __call__(self, order: dict[str, Any], body: bytes) -> bytes:
        try:
            return self._template(order, body)
        except ScanError as error:
            return pack({"kind": "refused", "why": error.fault, "detail": error.detail})
        except ParameterError as error:
            return pack({"kind": "parameter", "detail": str(error)})
        except MemoryError:
            return pack({"kind": "refused", "why": "file exceeds a limit", "detail": "memory"})

    def _template(self, fields: dict[str, Any], body: bytes) -> bytes:
        order = order_from(fields)
        trace = self._recognizer.pipeline.trace(order.read(body))
        if trace.frontal is None:
            return pack({"kind": "no face", "why": trace.reason})
        template = template_to_bytes(self._recognizer.template(trace, augment=order.augment))
        frontal = frontal_to_bytes(trace.frontal) if order.keep else b""
        return pack({"kind": "template", "bytes": len(template)}, template + frontal)


def _send(outbox: BinaryIO, message: bytes) -> None:
    outbox.write(message)
    outbox.flush()


def _limit() -> None:
    """No more memory than now and `_MEMORY`, and no core dump that would hold a face."""
    try:
        import resource
    except ImportError:  # no such limits on this system; the readers' own hold all the same
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            now = int(file.read().split()[0]) * resource.getpagesize()
    except OSError:
        return
    resource.setrlimit(resource.RLIMIT_AS, (now + _MEMORY,) * 2)


if __name__ == "__main__":
    main()
