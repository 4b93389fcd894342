"""What a template depends on, as bytes to be hashed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from rangeface.classify import fitted_state
from rangeface.pipeline._head import Head
from rangeface.pipeline._step import Step


def fingerprint(value: Any) -> str:
    """SHA-256 of a value's `parts`: 64 hex digits."""
    digest = hashlib.sha256()
    for part in parts(value):
        digest.update(part)
    return digest.hexdigest()


def parts(value: Any) -> Iterator[bytes]:
    """The bytes that a value's identity depends on, prefix-free."""
    if isinstance(value, Step):
        number = getattr(value.method, "revision", 1)
        yield f"step {value.method.__module__}.{value.name} r{number};".encode()
        yield from parts(value.all_params())
    elif isinstance(value, Head):
        estimator = value.classify
        yield from parts(value.describe)
        yield f"head {type(estimator).__name__} r{getattr(estimator, 'revision', 1)};".encode()
        yield from parts(estimator.get_params())
        yield from parts(fitted_state(estimator))
    elif isinstance(value, np.ndarray):
        yield f"array {value.dtype.str} {value.shape};".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif is_dataclass(value) and not isinstance(value, type):
        yield f"{type(value).__name__}(".encode()
        for f in fields(value):
            yield f"{f.name}=".encode()
            yield from parts(getattr(value, f.name))
        yield b")"
    elif hasattr(value, "items"):
        yield f"map {len(value)};".encode()
        for key in sorted(value):
            yield f"{key}:".encode()
            yield from parts(value[key])
    elif isinstance(value, list | tuple):
        yield f"list {len(value)};".encode()
        for item in value:
            yield from parts(item)
    else:
        yield f"{type(value).__name__} {value!r};".encode()
