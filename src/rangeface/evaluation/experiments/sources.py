"""Where an experiment's scans come from: simulated people, or a user's database.

A source lists scans by *view*; an experiment asks for views by name and does not know the rest.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

import numpy as np

from rangeface import datasets, sensors, simulate
from rangeface.errors import ParameterError
from rangeface.sensors import SensorModel
from rangeface.simulate import VIEWS
from rangeface.types import Pinhole, RangeImage, RigidTransform, Scan

Rng: TypeAlias = np.random.Generator

#: GavabDB's names of the views, in ours.
_GAVAB = {
    "frontal1": "frontal1", "frontal2": "frontal2", "arriba": "up", "abajo": "down",
    "derecha": "right", "izquierda": "left", "gesto": "gesture", "risa": "laugh",
    "sonrisa": "smile",
}  # fmt: skip

#: A light-stripe scanner's view of a head: 1.4 mm between points, as in GavabDB.
SCANNER = Pinhole(640.0, 640.0, 99.5, 99.5, 200, 200)
SCANNER_MM = 900.0

KINDS = ("synthetic", "ict", "gavab", "rap3df")


@dataclass(frozen=True)
class Source:
    """People and their scans.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    persons : int
        How many people.
    seed : int
        Simulated people are numbers 1000 · seed and up: seeds share nobody.
    folder : str
        The user's data; "" for simulated people.
    identity : str
        Hash of the data, so that other data under the same name are other data.
    """

    kind: str
    persons: int
    seed: int
    folder: str
    identity: str

    @property
    def training(self) -> tuple[str, ...]:
        """Views to learn and enrol from."""
        return ("gallery",) if self.kind == "rap3df" else ("frontal1", "smile")

    @property
    def probes(self) -> Mapping[str, str]:
        """Name of the column in the paper's tables → view."""
        if self.kind == "rap3df":
            return {"any": "probe"}
        return {"neutral": "frontal2", "smiling": "laugh"}

    @property
    def numbers(self) -> range:
        """Numbers of the simulated people."""
        return range(1000 * self.seed, 1000 * self.seed + self.persons)

    @property
    def simulated(self) -> bool:
        """Whether the people are heads that can be rendered, with a known pose."""
        return self.kind in ("synthetic", "ict")

    def need_heads(self, what: str) -> None:
        """Refuse a database where people must be simulated.

        Raises
        ------
        ParameterError
            The source is a database.
        """
        if not self.simulated:
            raise ParameterError(f"data: {what} needs people to simulate: synthetic or ict:PATH")

    def __str__(self) -> str:
        return f"{self.kind}, {self.persons} people" + (f", {self.folder}" if self.folder else "")


def source(data: str = "synthetic", *, persons: int = 61, seed: int = 0) -> Source:
    """The source that a user names.

    Parameters
    ----------
    data : str
        "synthetic", or "ict:PATH", "gavab:PATH", "rap3df:PATH".
    persons : int
        How many people, ≥ 2; of a database, at most as many as it has.
    seed : int
        Which simulated people, ≥ 0.

    Returns
    -------
    Source

    Raises
    ------
    ParameterError
        An unknown kind, no path, or a number out of range.
    ScanError
        The folder does not exist or holds no such data.
    """
    kind, _, folder = data.partition(":")
    if kind not in KINDS or bool(folder) == (kind == "synthetic"):
        raise ParameterError(f"data: {data!r}; known: synthetic, ict:PATH, gavab:PATH, rap3df:PATH")
    if persons < 2 or seed < 0:
        raise ParameterError(f"persons, seed: need ≥ 2 and ≥ 0, got {persons}, {seed}")
    if kind == "synthetic":
        return Source(kind, persons, seed, "", _population(kind, ""))
    if kind == "ict":
        return Source(kind, persons, seed, folder, _population(kind, folder))
    scans = _database(kind, folder)
    people = len({scan.subject for scan in scans})
    return Source(kind, min(persons, people), seed, folder, _contents(scans))


def scans_of(source: Source, view: str) -> list[tuple[int, RangeImage]]:
    """The scans of a view as (number of the person, image), by person.

    Raises
    ------
    ParameterError
        The source has no such view.
    ScanError
        A file is broken.
    """
    if source.simulated:
        if view not in VIEWS:
            raise ParameterError(f"view: unknown {view!r}; known: {', '.join(VIEWS)}")
        return [(k, _simulated(source, person, view)) for k, person in enumerate(source.numbers)]
    scans = database(source)
    people = list(dict.fromkeys(scan.subject for scan in scans))
    found = [(people.index(scan.subject), _one(scan)) for scan in scans if _view(scan) == view]
    if not found:
        raise ParameterError(
            f"data: {source.kind} has no scans of the view {view!r} that this experiment needs"
        )
    return found


# ── simulated people ─────────────────────────────────────────────────────────────────────


def head_of(source: Source, person: int, *, expression: str, session: int) -> simulate.Head:
    """The head of a simulated person."""
    if source.kind == "ict":
        return _model(source.folder).head(person, expression=expression, session=session)
    return simulate.head(person, expression=expression, session=session)


def scanner() -> SensorModel:
    """The scanner that simulated people sit before."""
    return replace(sensors.preset("laser-scanner"), camera=SCANNER)


def sitting(person: int, view: str, distance_mm: float) -> tuple[RigidTransform, Rng]:
    """How a person sits for a view, T_camera_face, and the generator that goes on from there."""
    rng = np.random.default_rng([person, list(VIEWS).index(view), 0x5CA9])
    asked = VIEWS[view]
    # nobody sits twice in the same way
    yaw, pitch, roll = rng.normal(0.0, 2.0, 3)
    tip = (*rng.normal(0.0, 4.0, 2), distance_mm + rng.normal(0.0, 8.0))
    pose = simulate.pose(
        yaw_deg=asked.yaw_deg + yaw, pitch_deg=asked.pitch_deg + pitch, roll_deg=roll,
        nose_tip_mm=tip,
    )  # fmt: skip
    return pose, rng


def head_in(source: Source, person: int, view: str) -> simulate.Head:
    """The head of a simulated person with the expression and on the day of a view."""
    asked = VIEWS[view]
    return head_of(source, person, expression=asked.expression, session=asked.session)


def _simulated(source: Source, person: int, view: str) -> RangeImage:
    pose, rng = sitting(person, view, SCANNER_MM)
    scene = simulate.render(head_in(source, person, view), SCANNER, pose)
    return simulate.capture(scene, scanner(), rng=rng)


@lru_cache(maxsize=1)
def _model(folder: str) -> simulate.MorphableModel:
    return simulate.ict_facekit(folder)


@lru_cache(maxsize=4)
def _population(kind: str, folder: str) -> str:
    """Hash of a few people: when the model of heads changes, they are other people."""
    model = _model(folder).head if kind == "ict" else simulate.head
    digest = hashlib.sha256()
    for person, expression in ((0, "neutral"), (1, "smile"), (2, "laugh")):
        digest.update(model(person, expression=expression, session=1).surface.points.tobytes())
    return digest.hexdigest()


# ── databases ────────────────────────────────────────────────────────────────────────────


def database(source: Source) -> list[Scan]:
    """The scans of the people of a source that is a database."""
    scans = _database(source.kind, source.folder)
    people = list(dict.fromkeys(scan.subject for scan in scans))[: source.persons]
    return [scan for scan in scans if scan.subject in people]


def _database(kind: str, folder: str) -> list[Scan]:
    return datasets.gavab(folder) if kind == "gavab" else datasets.rap3df(folder)


def _view(scan: Scan) -> str:
    return _GAVAB.get(scan.session, scan.role)


def _one(scan: Scan) -> RangeImage:
    loaded = scan.load()
    return loaded if isinstance(loaded, RangeImage) else loaded[0]


def _contents(scans: list[Scan]) -> str:
    digest = hashlib.sha256()
    for scan in scans:
        digest.update(hashlib.sha256(Path(scan.path).read_bytes()).digest())
    return digest.hexdigest()
