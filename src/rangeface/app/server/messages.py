"""What the service and its workers say to each other: a JSON object and bytes.

Each message is two lengths (u32, little-endian), the JSON, the bytes. Nothing is pickled, so what a
captured worker says is checked like any other input.
"""

from __future__ import annotations

import json
import struct
from typing import Any, TypeAlias

_HEAD = struct.Struct("<II")
HEAD_BYTES = _HEAD.size

Message: TypeAlias = "tuple[dict[str, Any], bytes]"


def pack(fields: dict[str, Any], body: bytes = b"") -> bytes:
    """A message as bytes."""
    text = json.dumps(fields).encode()
    return _HEAD.pack(len(text), len(body)) + text + body


def lengths(head: bytes) -> tuple[int, int]:
    """Lengths of the JSON and of the bytes that follow a message's head."""
    text, body = _HEAD.unpack(head)
    return text, body
