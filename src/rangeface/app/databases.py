"""`rangeface datasets`: what can be read, what a folder holds, and a protocol's scans."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from rich.markup import escape
from rich.table import Table

from rangeface.app.console import console
from rangeface.datasets import DATABASES
from rangeface.datasets._folder import Database
from rangeface.errors import ParameterError
from rangeface.types import Scan


def show(name: str | None, path: Path | None) -> None:
    """List the databases, describe one, or check a folder."""
    if name is None:
        table = Table("name", "database", "protocols")
        for key, database in DATABASES.items():
            table.add_row(key, escape(database.title), ", ".join(database.protocols))
        console.print(table)
        return
    database = _known(name)
    console.print(f"{database.title}\nlayout: {database.layout}", markup=False, highlight=False)
    console.print(f"protocols: {', '.join(database.protocols)}", markup=False, highlight=False)
    if path is not None:
        _check(database, path)


def scans(name: str, path: Path, protocol: str | None) -> list[Scan]:
    """The scans of a folder with the roles that a protocol gives them."""
    database = _known(name)
    protocol = next(iter(database.protocols)) if protocol is None else protocol
    if protocol not in database.protocols:
        known = ", ".join(database.protocols)
        raise ParameterError(f"protocol: {name} has no {protocol!r}; known: {known}")
    return database.protocols[protocol](database.index(path))


def _check(database: Database, path: Path) -> None:
    found = database.index(path)
    people = len({scan.subject for scan in found})
    console.print(f"{path}: {len(found)} scans of {people} people", markup=False, highlight=False)
    for role, count in Counter(scan.role or "no role" for scan in found).items():
        console.print(f"  {role}: {count}", highlight=False)
    for line in database.missing(found):
        console.print(f"  missing: {line}", markup=False, highlight=False)


def _known(name: str) -> Database:
    if name not in DATABASES:
        raise ParameterError(f"unknown database {name!r}; known: {', '.join(DATABASES)}")
    return DATABASES[name]
