"""The simulated people that the shipped model is trained on: many sensors, poses, expressions."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from rangeface.errors import ParameterError
from rangeface.evaluation.synthetic import Visit, capture
from rangeface.types import Scan

#: Training people are numbered from here, so that no evaluation meets them.
FIRST_PERSON = 1_000_000

#: (sensor, distance mm, frames, largest yaw °): noise from well below 1 mm to about 7 mm on the
#: face, and heads turned until part of a cheek is hidden.
CAMERAS = (
    ("sr3000", 400.0, 10, 10.0),
    ("kinect-v2", 700.0, 1, 30.0),
    ("pmd-flexx2", 450.0, 3, 20.0),
    ("sr3000", 450.0, 3, 30.0),
)
EXPRESSIONS = ("neutral", "smile", "laugh", "neutral")


def training_scans(people: int, seed: int = 0) -> list[Scan]:
    """Four captures of each person: every camera, different days, poses and expressions.

    Parameters
    ----------
    people : int
        ≥ 2.
    seed : int
        ≥ 0; different seeds are different people.

    Returns
    -------
    list of Scan
        Role "train".

    Raises
    ------
    ParameterError
        `people` < 2 or a negative seed.
    """
    if people < 2 or seed < 0:
        raise ParameterError(f"people, seed: need ≥ 2 and ≥ 0, got {people}, {seed}")
    first = FIRST_PERSON + 100_000 * seed
    return [scan for person in range(first, first + people) for scan in _person(person)]


def _person(person: int) -> list[Scan]:
    rng = np.random.default_rng([person, 0x7A11])
    scans = []
    for session, ((sensor, distance, frames, turn), expression) in enumerate(
        zip(CAMERAS, EXPRESSIONS, strict=True)
    ):
        yaw, pitch = rng.uniform(-turn, turn), rng.uniform(-0.5 * turn, 0.5 * turn)
        visit = Visit(f"visit-{session}", expression, session, float(yaw), float(pitch))
        loader = partial(
            capture, person=person, visit=visit, sensor=sensor, distance_mm=distance, frames=frames
        )
        scans.append(
            Scan(
                Path(f"train-{person}/{visit.view}"),
                loader,
                subject=f"train-{person}",
                role="train",
                session=str(session),
                expression=expression,
                sensor=sensor,
            )
        )
    return scans
