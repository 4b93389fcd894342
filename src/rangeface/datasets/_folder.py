"""What the databases share: a scan with its reader, and a clear word where none is found."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from rangeface.errors import ScanError, ScanFault
from rangeface.io import read_scan
from rangeface.types import Scan


def scan(path: Path, *, reading: dict[str, Any] | None = None, **facts: Any) -> Scan:
    """A scan that `read_scan` loads with the given options."""
    return Scan(path, partial(read_scan, **(reading or {})), **facts)


def found(path: str | Path, scans: list[Scan], layout: str) -> list[Scan]:
    """The scans, or the error that says what was looked for."""
    if not Path(path).is_dir():
        raise ScanError(path, ScanFault.MISSING, "no such folder")
    if not scans:
        raise ScanError(path, ScanFault.UNKNOWN_FORMAT, f"nothing here looks like {layout}")
    return scans
