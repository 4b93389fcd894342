"""Visits: who came, when, and on which side they left; counted and written down."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rangeface.errors import ParameterError
from rangeface.types import Template, Verdict

Point = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Visit:
    """One person before one camera, from coming to going.

    Parameters
    ----------
    track : int
        Number of the track.
    person : int, optional
        Number of the person; None where too little was seen to tell people apart.
    subject : str, optional
        Name, if enrolled.
    verdict : Verdict
        The last decision.
    start_s, stop_s : float
        First and last seen, by the camera's clock.
    first_mm, last_mm : tuple of float
        Where the nose tip was then, camera frame.
    looks : int
        Comparisons made.
    template : Template, optional
        How the person looked; not written to files.
    """

    track: int
    person: int | None
    subject: str | None
    verdict: Verdict
    start_s: float
    stop_s: float
    first_mm: Point
    last_mm: Point
    looks: int
    template: Template | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Doorway:
    """A plane that divides inside from outside.

    Parameters
    ----------
    axis : {"x", "y", "z"}
        Of the camera frame: x is to the right of the image, z away from the camera.
    at_mm : float
        Where the plane cuts it.
    inwards : {1, -1}
        1: who goes towards larger values goes in.
    margin_mm : float
        Who does not come from, and get to, this far beyond the plane has not passed.

    Raises
    ------
    ParameterError
        An unknown axis, or `inwards` is not 1 or −1.
    """

    axis: str = "x"
    at_mm: float = 0.0
    inwards: int = 1
    margin_mm: float = 30.0

    def __post_init__(self) -> None:
        if self.axis not in ("x", "y", "z"):
            raise ParameterError(f"axis: must be x, y or z, got {self.axis!r}")
        if self.inwards not in (1, -1):
            raise ParameterError(f"inwards: must be 1 or -1, got {self.inwards}")

    def direction(self, visit: Visit) -> str:
        """Which way a visit passed: "in", "out", or "" where it did not."""
        k = "xyz".index(self.axis)
        before = self.inwards * (visit.first_mm[k] - self.at_mm)
        after = self.inwards * (visit.last_mm[k] - self.at_mm)
        if before < -self.margin_mm and after > self.margin_mm:
            return "in"
        if before > self.margin_mm and after < -self.margin_mm:
            return "out"
        return ""


@dataclass(frozen=True)
class Counts:
    """How many passed a doorway.

    Parameters
    ----------
    went_in, went_out : int
        Passages.
    different_in, different_out : int
        Different people who made them.
    different : int
        Different people who were seen, whether they passed or not.
    nobody : int
        Visits of whom too little was seen to tell people apart; in the passages only.
    """

    went_in: int
    went_out: int
    different_in: int
    different_out: int
    different: int
    nobody: int


def count_people(visits: Iterable[Visit], doorway: Doorway | None = None) -> Counts:
    """Count passages, and the different people who made them.

    Parameters
    ----------
    visits : iterable of Visit
        Of one camera.
    doorway : Doorway, optional
        Default: the middle of the image, inwards to the right.

    Returns
    -------
    Counts
    """
    door = doorway or Doorway()
    everybody = list(visits)
    ways = [(door.direction(v), v.person) for v in everybody]
    people = {way: {p for w, p in ways if w == way and p is not None} for way in ("in", "out")}
    return Counts(
        went_in=sum(w == "in" for w, _ in ways),
        went_out=sum(w == "out" for w, _ in ways),
        different_in=len(people["in"]),
        different_out=len(people["out"]),
        different=len({v.person for v in everybody if v.person is not None}),
        nobody=sum(v.person is None for v in everybody),
    )


def write_visits(
    path: str | Path, visits: Sequence[Visit], *, doorway: Doorway | None = None, source: str = ""
) -> None:
    """Write visits to a CSV or JSON file, one row a visit, without templates.

    Parameters
    ----------
    path : str or Path
        Ends in ``.csv`` or ``.json``.
    visits : sequence of Visit
    doorway : Doorway, optional
        Adds the direction.
    source : str
        The camera's address, written into every row.

    Raises
    ------
    ParameterError
        The ending is another.
    """
    rows = [_row(visit, doorway or Doorway(), source) for visit in visits]
    write_rows(path, rows, _COLUMNS)


def write_rows(path: str | Path, rows: Sequence[dict[str, Any]], columns: Sequence[str]) -> None:
    """Write a table to a CSV or JSON file; raises ParameterError for another ending."""
    target = Path(path)
    if target.suffix.lower() == ".json":
        target.write_text(json.dumps(list(rows), indent=1) + "\n", encoding="utf-8")
    elif target.suffix.lower() == ".csv":
        with target.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.DictWriter(stream, columns, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    else:
        raise ParameterError(f"path: ending {target.suffix!r}, not .csv or .json")


_COLUMNS = ("source", "track", "person", "subject", "verdict", "start_s", "stop_s", "direction",
            "looks", "first_x_mm", "first_z_mm", "last_x_mm", "last_z_mm")  # fmt: skip


def _row(visit: Visit, doorway: Doorway, source: str) -> dict[str, Any]:
    return {
        "source": source,
        "track": visit.track,
        "person": visit.person,
        "subject": visit.subject,
        "verdict": str(visit.verdict),
        "start_s": round(visit.start_s, 3),
        "stop_s": round(visit.stop_s, 3),
        "direction": doorway.direction(visit),
        "looks": visit.looks,
        "first_x_mm": round(visit.first_mm[0], 1),
        "first_z_mm": round(visit.first_mm[2], 1),
        "last_x_mm": round(visit.last_mm[0], 1),
        "last_z_mm": round(visit.last_mm[2], 1),
    }
