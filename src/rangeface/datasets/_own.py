"""A user's own data: a folder with an ``index.csv``.

::

    path,subject,role,view,session
    anna/1.png,anna,gallery,frontal,2024-03-01
    anna/2.png,anna,probe,left,2024-03-02

`role` is train, gallery or probe; `path` is relative to the index; view, session, expression
and sensor may be missing or empty. A ``camera.toml`` beside the index serves all images that
have none nearer to them (see `rangeface.io.camera_toml`).
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from rangeface.datasets._folder import found, scan
from rangeface.errors import ScanError, ScanFault
from rangeface.types import Scan

LAYOUT = "index.csv with path,subject,role[,view,session,expression,sensor]; camera.toml"

_ROLES = ("train", "gallery", "probe")
_COLUMNS = ("path", "subject", "role", "view", "session", "expression", "sensor")
_MAX_BYTES = 64 << 20


def folder(path: str | Path) -> list[Scan]:
    """List the scans that an ``index.csv`` names.

    Parameters
    ----------
    path : str or Path
        The folder, or the index itself.

    Returns
    -------
    list of Scan
        In the order of the index. A file that is missing or broken is reported when it is
        loaded, so that a run over many goes on.

    Raises
    ------
    ScanError
        There is no index, a column is missing or unknown, or a row lacks a path or a subject
        or has an unknown role.
    """
    index = Path(path)
    index = index if index.suffix == ".csv" else index / "index.csv"
    rows = _rows(index)
    scans = []
    for number, row in rows:
        if not row["path"] or not row["subject"]:
            raise _error(index, f"line {number}: path and subject must be given")
        if row.get("role", "") not in _ROLES:
            raise _error(index, f"line {number}: role {row.get('role')!r}, not {_ROLES}")
        facts: dict[str, Any] = {name: row[name] for name in _COLUMNS[1:] if name in row}
        scans.append(scan(index.parent / row["path"], **facts))
    return found(index.parent, scans, "rows of an index.csv")


def _rows(index: Path) -> list[tuple[int, dict[str, str]]]:
    try:
        if index.stat().st_size > _MAX_BYTES:
            raise ScanError(index, ScanFault.TOO_LARGE, f"an index has at most {_MAX_BYTES} bytes")
        text = index.read_text(encoding="utf-8-sig")
        lines = csv.reader(text.splitlines(), strict=True)
        header = [name.strip() for name in next(lines, [])]
        table = [(lines.line_num, [cell.strip() for cell in line]) for line in lines if line]
    except FileNotFoundError:
        raise ScanError(index, ScanFault.MISSING, f"columns {','.join(_COLUMNS[:5])}") from None
    except (OSError, ValueError, csv.Error) as fault:
        raise _error(index, str(fault)) from None
    for name in _COLUMNS[:3]:
        if name not in header:
            raise _error(index, f"column {name!r} is missing")
    unknown = set(header) - set(_COLUMNS)
    if unknown:
        raise _error(index, f"unknown column {sorted(unknown)[0]!r}; known: {', '.join(_COLUMNS)}")
    for number, cells in table:
        if len(cells) != len(header):
            raise _error(index, f"line {number} has {len(cells)} cells, the header {len(header)}")
    return [(number, dict(zip(header, cells, strict=True))) for number, cells in table]


def _error(index: Path, detail: str) -> ScanError:
    return ScanError(index, ScanFault.MALFORMED, detail)


def missing(scans: list[Scan]) -> list[str]:
    """Which files of the index are not there, and who is tested but not enrolled."""
    lines = [f"{s.path}: no such file" for s in scans if not s.path.exists()]
    enrolled = {s.subject for s in scans if s.role == "gallery"}
    tested = {s.subject for s in scans if s.role == "probe"}
    return lines + [f"{name}: probes, but nothing enrolled" for name in sorted(tested - enrolled)]
