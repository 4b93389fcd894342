"""Array aliases, read-only copies, and the mark of a method's revision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError

Float32: TypeAlias = NDArray[np.float32]
Float64: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]

_F = TypeVar("_F", bound=Callable[..., Any])


def revision(number: int) -> Callable[[_F], _F]:
    """Mark a method's revision; raised by hand when, and only when, its numbers change.

    Parameters
    ----------
    number : int
        Revision, ≥ 1. A method without the mark has revision 1.

    Returns
    -------
    callable
        Decorator that returns the method itself.
    """

    def mark(method: _F) -> _F:
        method.revision = number  # type: ignore[attr-defined]
        return method

    return mark


def frozen(array: ArrayLike, dtype: type, name: str, shape: tuple[int, ...] | None) -> NDArray[Any]:
    """A read-only copy; the shape is checked where one is given."""
    out: NDArray[Any] = np.array(array, dtype=dtype, order="C")
    if shape is not None and out.shape != shape:
        raise ParameterError(f"{name}: shape {out.shape} does not match {shape}")
    out.flags.writeable = False
    return out
