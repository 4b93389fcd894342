"""People before a simulated SR-3000, and the templates that the model that ships makes of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rangeface import sensors, simulate
from rangeface.errors import NoFaceError
from rangeface.evaluation.experiments import models
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.evaluation.synthetic import window
from rangeface.types import RangeImage, Template

SENSOR, DISTANCE_MM = "sr3000", 400.0
#: People of a cell.
CHUNK = 25
#: An expression that is held is never quite the same: standard deviation of its strength.
_STRENGTH_SIGMA = 0.15
#: Nobody shows the same neutral face twice: a little of a random gesture on the other day.
_RESTLESS = 0.12


class Visit(NamedTuple):
    """One capture of a person: what is shown, on which day (0: enrolment), in how many frames."""

    expression: str
    session: int
    frames: int


ENROLMENT = Visit("neutral", 0, 10)


@kept
def templates(
    store: Store,
    *,
    source: Source,
    model: str,
    expression: str,
    session: int,
    frames: int,
    first: int,
    count: int,
) -> Arrays:
    """Templates of people who came once; those of the day of enrolment are augmented.

    Returns
    -------
    dict
        "k.h": rows of head h of person first + k; none of a person who failed to acquire.
    """
    asked, visit = models.recognizer(model), Visit(expression, session, frames)
    made: dict[str, np.ndarray] = {}
    for k in range(count):
        seen = frames_of(source, first + k, visit)
        image = seen if frames > 1 else seen[0]
        try:
            template = asked.template(image, augment=session == ENROLMENT.session)
        except NoFaceError:
            continue
        made |= {f"{k}.{h}": rows for h, rows in enumerate(template.vectors)}
    return made


def templates_of(source: Source, visit: Visit, people: range) -> tuple[Cell, ...]:
    """The cells of people's templates."""
    return tuple(
        cell(
            templates, source=source, model=models.shipped(), **visit._asdict(),
            first=people[k], count=len(people[k : k + CHUNK]),
        )
        for k in range(0, len(people), CHUNK)
    )  # fmt: skip


def made(store: Store, cells: Sequence[Cell], fingerprint: str) -> list[Template | None]:
    """Templates that cells of `templates` hold, by person; None where the person failed.

    Parameters
    ----------
    store : Store
    cells : sequence of Cell
    fingerprint : str
        Of the pipeline that made them.

    Returns
    -------
    list of Template or None
    """
    found: list[Template | None] = []
    for one in cells:
        arrays = store.get(one)
        for k in range(dict(one.params)["count"]):
            vectors = tuple(rows for name, rows in arrays.items() if name.startswith(f"{k}."))
            found.append(Template(vectors, fingerprint) if vectors else None)
    return found


def frames_of(source: Source, person: int, visit: Visit) -> list[RangeImage]:
    """The frames of one visit, always the same.

    Parameters
    ----------
    source : Source
        Of heads.
    person : int
    visit : Visit

    Returns
    -------
    list of RangeImage
    """
    rng = np.random.default_rng([person, visit.session, visit.frames, *visit.expression.encode()])
    strength = float(np.clip(rng.normal(1.0, _STRENGTH_SIGMA), 0.5, 1.4))
    head_of, session = _population(source), visit.session
    head = head_of(person, expression=visit.expression, strength=strength, session=session)
    if session != ENROLMENT.session:
        restless = head_of(person, expression="random", strength=_RESTLESS, session=session)
        shift = restless.surface.points - head_of(person, session=session).surface.points
        head = replace(head, surface=replace(head.surface, points=head.surface.points + shift))
    yaw, pitch, roll = rng.normal(0.0, 3.0, 3)
    x, y = rng.normal(0.0, 10.0, 2)
    pose = simulate.pose(
        yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll, nose_tip_mm=(x, y, DISTANCE_MM)
    )
    sensor = sensors.preset(SENSOR)
    sensor = replace(sensor, camera=window(sensor.camera, DISTANCE_MM))
    scene = simulate.render(head, sensor.camera, pose, oversample=3)
    return list(simulate.frames(scene, sensor, visit.frames, rng=rng))


def _population(source: Source) -> Callable[..., simulate.Head]:
    return _ict(source.folder).head if source.kind == "ict" else simulate.head


@lru_cache(maxsize=1)
def _ict(folder: str) -> simulate.MorphableModel:
    return simulate.ict_facekit(folder)
