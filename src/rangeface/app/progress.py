"""Progress bars on long work, quiet when nobody watches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

from rich.console import Console
from rich.progress import track

T = TypeVar("T")

#: Progress goes to standard error, so that standard output stays a result.
err = Console(stderr=True)


def over(items: Sequence[T], what: str) -> Iterable[T]:
    """Iterate with a progress bar and the time left, on a terminal's standard error."""
    return track(items, what, console=err, transient=True, disable=not err.is_terminal)
