"""A whole database of simulated people, in the views of GavabDB."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from rangeface.errors import ParameterError
from rangeface.sensors import SensorModel
from rangeface.simulate._capture import capture
from rangeface.simulate._head import head
from rangeface.simulate._scene import pose, render
from rangeface.types import RangeImage, RigidTransform


@dataclass(frozen=True)
class View:
    """How a person is asked to look: angles in degrees, expression, visit."""

    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    expression: str = "neutral"
    session: int = 0


# the nine scans of each person in GavabDB: A. B. Moreno, A. Sánchez, Proc. COST 275, 2004
VIEWS: Mapping[str, View] = MappingProxyType(
    {
        "frontal1": View(),
        "frontal2": View(session=1),
        "up": View(pitch_deg=-35.0),
        "down": View(pitch_deg=35.0),
        "right": View(yaw_deg=-90.0),
        "left": View(yaw_deg=90.0),
        "gesture": View(expression="random", session=1),
        "laugh": View(expression="laugh"),
        "smile": View(expression="smile"),
    }
)


@dataclass(frozen=True, eq=False)
class Labelled:
    """One capture of a collection.

    Parameters
    ----------
    person : int
        Number of the person, as in `head`.
    view : str
        One of `VIEWS`.
    image : RangeImage
        What the camera captured.
    pose : RigidTransform
        True T_camera_face.
    """

    person: int
    view: str
    image: RangeImage
    pose: RigidTransform


def collection(
    people: Sequence[int],
    sensor: SensorModel,
    *,
    views: Sequence[str] = tuple(VIEWS),
    distance_mm: float = 400.0,
    unrest_deg: float = 3.0,
    oversample: int = 3,
    seed: int = 0,
    workers: int = 1,
) -> Iterator[Labelled]:
    """Captures of many people in several views, one by one.

    Parameters
    ----------
    people : sequence of int
        Numbers of the people.
    sensor : SensorModel
        With its camera.
    views : sequence of str
        Names of `VIEWS`.
    distance_mm : float
        Depth of the nose tip, mm, > 0.
    unrest_deg : float
        Standard deviation of each angle around the view's, degrees, ≥ 0.
    oversample : int
        As in `render`.
    seed : int
        Of unrest and noise, ≥ 0.
    workers : int
        Threads, ≥ 1; the result does not depend on their number.

    Yields
    ------
    Labelled
        In the order of people, then views.

    Raises
    ------
    ParameterError
        An unknown view, or a number out of range.

    Examples
    --------
    >>> from rangeface import sensors, simulate
    >>> two = simulate.collection([4, 9], sensors.preset("sr3000"), views=["frontal1", "laugh"])
    >>> [(capture.person, capture.view) for capture in two]
    [(4, 'frontal1'), (4, 'laugh'), (9, 'frontal1'), (9, 'laugh')]
    """
    for view in views:
        if view not in VIEWS:
            raise ParameterError(f"views: unknown {view!r}; known: {', '.join(VIEWS)}")
    if not distance_mm > 0:
        raise ParameterError(f"distance_mm: must be > 0, got {distance_mm}")
    if not unrest_deg >= 0:
        raise ParameterError(f"unrest_deg: must be ≥ 0, got {unrest_deg}")
    if workers < 1:
        raise ParameterError(f"workers: must be ≥ 1, got {workers}")
    if seed < 0:
        raise ParameterError(f"seed: must be ≥ 0, got {seed}")

    def make(person: int, name: str) -> Labelled:
        view = VIEWS[name]
        rng = np.random.default_rng([seed, person, list(VIEWS).index(name), 0xC011])
        angles = np.array([view.yaw_deg, view.pitch_deg, 0.0]) + unrest_deg * rng.normal(size=3)
        tip = (*rng.normal(0.0, 4.0, 2), distance_mm + rng.normal(0.0, 8.0))
        away = pose(yaw_deg=angles[0], pitch_deg=angles[1], roll_deg=angles[2], nose_tip_mm=tip)
        model = head(person, expression=view.expression, session=view.session)
        scene = render(model, sensor.camera, away, oversample=oversample)
        return Labelled(person, name, capture(scene, sensor, rng=rng), away)

    wanted = [(person, view) for person in people for view in views]
    if workers == 1:
        return (make(*one) for one in wanted)
    return _ahead(make, wanted, workers)


def _ahead(
    make: Callable[[int, str], Labelled], wanted: Sequence[tuple[int, str]], workers: int
) -> Iterator[Labelled]:
    # a few captures ahead of the consumer, never the whole database in memory
    waiting: deque[Future[Labelled]] = deque()
    with ThreadPoolExecutor(workers) as pool:
        for one in wanted:
            waiting.append(pool.submit(make, *one))
            if len(waiting) > 4 * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
