"""Progress bars on long work, quiet when nobody watches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

from rich.console import Console
from rich.progress import track

T = TypeVar("T")


def over(items: Sequence[T], what: str) -> Iterable[T]:
    """Iterate with a progress bar and the time left, on a terminal's standard error."""
    console = Console(stderr=True)
    return track(items, what, console=console, transient=True, disable=not console.is_terminal)
