"""A request's body, within its limits of size and time."""

from __future__ import annotations

import asyncio

from fastapi import Request

from rangeface.app.server.problems import Cause, RefusalError


async def read(request: Request, *, most: int, seconds: float) -> bytes:
    """The body.

    Raises
    ------
    RefusalError
        It is, or says that it is, larger than `most` bytes, or takes longer than `seconds`.
    """
    declared = request.headers.get("content-length", "0")
    if not declared.isdecimal() or int(declared) > most:
        raise RefusalError(Cause.BODY_TOO_LARGE, f"the limit is {most} bytes")
    try:
        async with asyncio.timeout(seconds):
            body = bytearray()
            async for chunk in request.stream():
                body += chunk
                if len(body) > most:
                    raise RefusalError(Cause.BODY_TOO_LARGE, f"the limit is {most} bytes")
    except TimeoutError:
        raise RefusalError(Cause.BODY_TOO_SLOW, f"the limit is {seconds:g} s") from None
    return bytes(body)
