"""The one console: as wide as the terminal, and wide enough for a table where there is none."""

from __future__ import annotations

from rich.console import Console

_PROBE = Console()

console = _PROBE if _PROBE.is_terminal else Console(width=120, soft_wrap=True)
