"""Who walks through the view of a synthetic camera, and when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rangeface.errors import ParameterError
from rangeface.sensors import SensorModel
from rangeface.simulate import Motion, pose
from rangeface.types import RigidTransform

#: The noses of two people who stand side by side.
_APART_MM = 230.0


@dataclass(frozen=True)
class Walk:
    """One person comes, stays and goes.

    Parameters
    ----------
    person : int
        Number of the head.
    start_s, stop_s : float
        When the person comes into being beside the view, and when it has left.
    place_mm : tuple of float
        Where it stays: nose tip, camera frame, mm.
    entry_mm, exit_mm : tuple of float
        Where it comes from and goes to.
    stride_s : float
        How long coming and going take each, s, > 0.
    expression : str
        Of `simulate.head`.
    session : int
        Day; 0 is the day of enrolment.
    turn_deg : float
        How far the head turns while it stays, degrees.

    Raises
    ------
    ParameterError
        The walk is shorter than its two strides.
    """

    person: int
    start_s: float
    stop_s: float
    place_mm: tuple[float, float, float]
    entry_mm: tuple[float, float, float]
    exit_mm: tuple[float, float, float]
    stride_s: float = 1.0
    expression: str = "neutral"
    session: int = 1
    turn_deg: float = 12.0

    def __post_init__(self) -> None:
        if not 0 < 2 * self.stride_s <= self.stop_s - self.start_s:
            raise ParameterError(
                f"stride_s: two strides of {self.stride_s} s do not fit into "
                f"{self.stop_s - self.start_s:.2f} s"
            )

    def at(self, time_s: float) -> RigidTransform | None:
        """Pose T_camera_face at a time; None where the person is not there."""
        if not self.start_s <= time_s < self.stop_s:
            return None
        inward = _smooth((time_s - self.start_s) / self.stride_s)
        outward = _smooth((time_s - self.stop_s + self.stride_s) / self.stride_s)
        entry, place, leave = (np.array(p) for p in (self.entry_mm, self.place_mm, self.exit_mm))
        still = inward * (1.0 - outward)
        away = (1.0 - inward) * (entry - place) + outward * (leave - place)
        sway = Motion(
            place_mm=(0.0, 0.0, 0.0), sway_mm=8.0 * still, yaw_deg=self.turn_deg * still,
            pitch_deg=6.0 * still, roll_deg=3.0, seed=1000 * self.person + round(self.start_s),
        ).at(time_s)  # fmt: skip
        # who walks across looks where he goes, by half
        heading = (1.0 - inward) * np.sign(place[0] - entry[0])
        heading += outward * np.sign(leave[0] - place[0])
        gait = pose(yaw_deg=25.0 * float(heading))
        where = place + away + sway.translation
        return RigidTransform(gait.rotation @ sway.rotation, where, "camera", "face")


def _smooth(fraction: float) -> float:
    t = min(max(fraction, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def distance_mm(sensor: SensorModel) -> float:
    """Where two people fit side by side into the view, mm."""
    camera = sensor.camera
    return 1.03 * camera.fx * (_APART_MM + 160.0) / camera.width


def comings_and_goings(
    sensor: SensorModel, people: Sequence[int] = (0, 1, 2, 3, 900, 901), *, stay_s: float = 6.0
) -> tuple[Walk, ...]:
    """A scene that repeats itself: two places, at each of which one person follows the other.

    Parameters
    ----------
    sensor : SensorModel
        Its view sets the distance.
    people : sequence of int
        Numbers of heads, at least one; they take the two places in turn.
    stay_s : float
        From coming to going, s, > 2.

    Returns
    -------
    tuple of Walk
        The last one stops when the scene is over.

    Raises
    ------
    ParameterError
        Nobody, or no time to stay.
    """
    if not people:
        raise ParameterError("people: at least one is needed")
    if not stay_s > 2.0:
        raise ParameterError(f"stay_s: must be > 2, got {stay_s}")
    z = distance_mm(sensor)
    walks = []
    for number, person in enumerate(people):
        side = -1.0 if number % 2 == 0 else 1.0
        # the right one comes half a stay later, so that there are none, one and two
        start = (number // 2) * (stay_s + 0.5) + (0.0 if side < 0 else 0.35 * stay_s)
        outside = (side * 0.9 * z * sensor.camera.width / sensor.camera.fx, 0.0, z)
        place = (side * 0.5 * _APART_MM, 0.0, z)
        walks.append(Walk(person, start, start + stay_s, place, outside, outside))
    return tuple(walks)
