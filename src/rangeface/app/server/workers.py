"""The processes that read scans: a few, kept, replaced when one is slow or dies."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import sys
import tempfile
from asyncio.subprocess import PIPE, Process
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from rangeface.app.server.messages import HEAD_BYTES, Message, lengths, pack
from rangeface.app.server.orders import Order
from rangeface.app.server.problems import Cause, RefusalError
from rangeface.errors import RangeFaceError
from rangeface.gallery import frontal_from_bytes, template_from_bytes
from rangeface.recognizer import FaceRecognizer
from rangeface.types import RangeImage, Reason, Template

_log = logging.getLogger("rangeface.service")

_ONE_THREAD: Mapping[str, str] = MappingProxyType(
    dict.fromkeys(
        ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
    )
)
_MODEL = "served.model"
_START_S = 300.0  # the kernels may have to be compiled


@dataclass(frozen=True, eq=False)
class Seen:
    """What a worker saw in a scan.

    Parameters
    ----------
    template : Template, optional
        None where the scan shows no face.
    frontal : RangeImage, optional
        If it was asked for.
    reason : Reason, optional
        Why there is no template.
    """

    template: Template | None
    frontal: RangeImage | None
    reason: Reason | None


class Workers:
    """A pool of worker processes, started and stopped with the service.

    Parameters
    ----------
    count : int
        Processes.
    queue : int
        Scans that may wait.
    seconds : float
        Longest time for a scan, s; a worker that takes longer is killed.
    """

    def __init__(self, *, count: int, queue: int, seconds: float) -> None:
        self._count, self._queue, self._seconds = count, queue, seconds
        self._idle: asyncio.Queue[Process] = asyncio.Queue()
        self._all: set[Process] = set()
        self._starting: set[asyncio.Task[None]] = set()
        self._waiting = 0
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    @property
    def ready(self) -> int:
        """Number of workers that have started."""
        return len(self._all)

    @property
    def waiting(self) -> int:
        """Number of scans in work or waiting."""
        return self._waiting

    async def start(self, recognizer: FaceRecognizer) -> None:
        """Start the processes; they become ready one after the other."""
        self._folder = tempfile.TemporaryDirectory(prefix="rangeface-")
        recognizer.save(Path(self._folder.name) / _MODEL)
        for _ in range(self._count):
            self._replace()

    async def stop(self) -> None:
        """End the processes."""
        for task in self._starting:
            task.cancel()
        await asyncio.gather(*self._starting, return_exceptions=True)
        for process in self._all:
            if process.returncode is None:
                process.kill()
            await process.wait()
        self._all.clear()
        if self._folder is not None:
            self._folder.cleanup()

    async def see(self, body: bytes, order: Order) -> Seen:
        """Have a scan read and a template made.

        Raises
        ------
        RefusalError
            All workers are busy, or the scan is refused or takes too long.
        """
        if self._waiting >= self._count + self._queue:
            raise RefusalError(Cause.BUSY, f"{self._waiting} scans are waiting", retry_s=1.0)
        self._waiting += 1
        try:
            fields, data = await self._ask(pack(order.to_json(), body))
        finally:
            self._waiting -= 1
        return _seen(fields, data)

    async def _ask(self, message: bytes) -> Message:
        process = await self._idle.get()
        try:
            async with asyncio.timeout(self._seconds):
                answer = await _converse(process, message)
        except TimeoutError:
            self._discard(process)
            raise RefusalError(Cause.SCAN_TOO_SLOW, f"the limit is {self._seconds:g} s") from None
        except (asyncio.IncompleteReadError, ConnectionError, ValueError):
            self._discard(process)
            _log.error("a worker died of a scan")
            raise RefusalError(Cause.SCAN_REFUSED, "its reader failed") from None
        except BaseException:  # cancelled in the middle of a conversation
            self._discard(process)
            raise
        self._idle.put_nowait(process)
        return answer

    def _discard(self, process: Process) -> None:
        self._all.discard(process)
        if process.returncode is None:
            process.kill()
        self._replace()

    def _replace(self) -> None:
        task = asyncio.create_task(self._launch())
        self._starting.add(task)
        task.add_done_callback(self._starting.discard)

    async def _launch(self) -> None:
        assert self._folder is not None
        model = Path(self._folder.name) / _MODEL
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "rangeface.app.server.worker", str(model),
            stdin=PIPE, stdout=PIPE, env={**os.environ, **_ONE_THREAD}, start_new_session=True,
        )  # fmt: skip
        try:
            async with asyncio.timeout(_START_S):
                await _receive(process)
        except BaseException as error:
            if process.returncode is None:
                process.kill()
            if not isinstance(error, asyncio.CancelledError):  # the service is being stopped
                _log.error("a worker did not start: %s", type(error).__name__)
            raise
        self._all.add(process)
        self._idle.put_nowait(process)


async def _converse(process: Process, message: bytes) -> Message:
    assert process.stdin is not None
    process.stdin.write(message)
    await process.stdin.drain()
    return await _receive(process)


async def _receive(process: Process) -> Message:
    assert process.stdout is not None
    text, body = lengths(await process.stdout.readexactly(HEAD_BYTES))
    fields = json.loads(await process.stdout.readexactly(text))
    return fields, await process.stdout.readexactly(body)


def _seen(fields: dict[str, Any], data: bytes) -> Seen:
    """What a worker's answer says, checked."""
    match fields["kind"]:
        case "template":
            try:
                size = int(fields["bytes"])
                frontal = frontal_from_bytes(data[size:]) if len(data) > size else None
                return Seen(template_from_bytes(data[:size]), frontal, None)
            except RangeFaceError:
                raise RefusalError(Cause.SCAN_REFUSED, "its reader failed") from None
        case "no face":
            return Seen(None, None, Reason(fields["why"] or Reason.NO_FACE))
        case "parameter":
            raise RefusalError(Cause.BAD_PARAMETER, fields["detail"])
        case _:
            raise RefusalError(Cause.SCAN_REFUSED, fields["detail"], why=fields["why"])
