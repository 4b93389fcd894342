"""What the databases share: finding files, scans with their reader, roles, and a clear word."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from rangeface.errors import ScanError, ScanFault
from rangeface.io import read_scan
from rangeface.types import Scan


@dataclass(frozen=True)
class Database:
    """A supported database, for a person who has it or looks for it.

    Parameters
    ----------
    title : str
        What it is.
    layout : str
        The files that are expected, one pattern a line.
    index : callable
        The user's folder → list of Scan.
    protocols : mapping of str to callable
        Name → list of Scan, with roles set; scans that a protocol does not use are left out.
    missing : callable
        list of Scan → lines that say what the whole database has and this folder has not.
    """

    title: str
    layout: str
    index: Callable[[Path], list[Scan]]
    protocols: Mapping[str, Callable[[list[Scan]], list[Scan]]]
    missing: Callable[[list[Scan]], list[str]]


def scan(path: Path, *, reading: dict[str, Any] | None = None, **facts: Any) -> Scan:
    """A scan that `read_scan` loads with the given options."""
    return Scan(path, partial(read_scan, **(reading or {})), **facts)


def matching(path: str | Path, pattern: str) -> Iterator[tuple[Path, re.Match[str]]]:
    """All files below a folder whose name matches, by path."""
    expression = re.compile(pattern, re.IGNORECASE)
    root = Path(path)
    for file in sorted(root.rglob("*")) if root.is_dir() else ():
        match = expression.fullmatch(file.name)
        if match is not None and file.is_file():
            yield file, match


def found(path: str | Path, scans: list[Scan], layout: str) -> list[Scan]:
    """The scans, or the error that says what was looked for."""
    if not Path(path).is_dir():
        raise ScanError(path, ScanFault.MISSING, "no such folder")
    if not scans:
        raise ScanError(path, ScanFault.UNKNOWN_FORMAT, f"nothing here looks like {layout}")
    return scans


def by_subject(scans: list[Scan]) -> dict[str, list[Scan]]:
    """The scans of each subject, in their order."""
    people: dict[str, list[Scan]] = {}
    for item in scans:
        people.setdefault(item.subject, []).append(item)
    return people


def first_against_rest(scans: list[Scan], is_gallery: Callable[[Scan], bool]) -> list[Scan]:
    """Enrol each subject's first scan that qualifies; all others of enrolled people are probes."""
    out = []
    for own in by_subject(scans).values():
        chosen = next((item for item in own if is_gallery(item)), None)
        if chosen is not None:
            out += [replace(s, role="gallery" if s is chosen else "probe") for s in own]
    return out


def counted(have: int, whole: int, what: str) -> list[str]:
    """One line where fewer are there than the whole database has."""
    return [f"{have} of {whole} {what}"] if have < whole else []
