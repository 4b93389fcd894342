"""Simulated captures as scans: a data set that needs no data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from rangeface import sensors, simulate
from rangeface.errors import ParameterError
from rangeface.types import Pinhole, RangeImage, Scan


@dataclass(frozen=True)
class Visit:
    """How a person stands before the camera, once.

    Parameters
    ----------
    view : str
        Its name.
    expression : str
        Of `simulate.head`.
    session : int
        0 = the day of enrolment.
    yaw_deg, pitch_deg : float
        Of the head.
    """

    view: str
    expression: str = "neutral"
    session: int = 0
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0


GALLERY = Visit("frontal")
PROBES = (
    Visit("neutral", session=1),
    Visit("smile", expression="smile", session=1),
    Visit("turned", session=1, yaw_deg=15.0),
    Visit("down", session=1, pitch_deg=10.0),
)


def scans(
    *,
    people: int,
    sensor: str = "sr3000",
    distance_mm: float = 400.0,
    frames: int = 1,
    gallery_frames: int = 10,
    probes: Sequence[Visit] = PROBES,
    seed: int = 0,
) -> list[Scan]:
    """List simulated captures: one enrolment a person, and probes of another day.

    Parameters
    ----------
    people : int
        Number of people, ≥ 1.
    sensor : str
        Preset of `rangeface.sensors`.
    distance_mm : float
        From camera to nose tip, > 0.
    frames, gallery_frames : int
        Frames in a probe and in an enrolment, ≥ 1 (ten is the source paper's average).
    probes : sequence of Visit
        What every person does on the other day.
    seed : int
        Person k is head number 1000 · seed + k.

    Returns
    -------
    list of Scan
        Roles "gallery" and "probe"; `load` simulates, always the same.

    Raises
    ------
    ParameterError
        A number is out of range, or the sensor is unknown.
    """
    for name, value in (("people", people), ("frames", frames), ("gallery_frames", gallery_frames)):
        if value < 1:
            raise ParameterError(f"{name} must be ≥ 1, got {value}")
    if not distance_mm > 0:
        raise ParameterError(f"distance_mm must be > 0, got {distance_mm}")
    sensors.preset(sensor)
    out = []
    for person in range(1000 * seed, 1000 * seed + people):
        for role, visits, count in (
            ("gallery", (GALLERY,), gallery_frames),
            ("probe", probes, frames),
        ):
            for visit in visits:
                loader = partial(
                    capture,
                    person=person,
                    visit=visit,
                    sensor=sensor,
                    distance_mm=distance_mm,
                    frames=count,
                )
                out.append(
                    Scan(
                        Path(f"person-{person}/{role}-{visit.view}"),
                        loader,
                        subject=f"person-{person}",
                        role=role,
                        session=str(visit.session),
                        view=visit.view,
                        expression=visit.expression,
                        sensor=sensor,
                    )
                )
    return out


def capture(
    path: Path,
    *,
    person: int,
    visit: Visit,
    sensor: str,
    distance_mm: float,
    frames: int,
) -> list[RangeImage]:
    """Simulate the frames of one visit; `path` names them and seeds their noise.

    Parameters
    ----------
    path : Path
        Name of the capture.
    person : int
        Number of the head.
    visit : Visit
        What it does.
    sensor : str
        Preset.
    distance_mm : float
        From camera to nose tip.
    frames : int
        Number of frames.

    Returns
    -------
    list of RangeImage
    """
    rng = np.random.default_rng([person, frames, *str(path).encode()])
    model = sensors.preset(sensor)
    head = simulate.head(person, expression=visit.expression, session=visit.session)
    yaw, pitch, roll = rng.normal(0.0, 2.0, 3)
    x, y = rng.normal(0.0, 10.0, 2)
    pose = simulate.pose(
        yaw_deg=visit.yaw_deg + yaw,
        pitch_deg=visit.pitch_deg + pitch,
        roll_deg=roll,
        nose_tip_mm=(x, y, distance_mm),
    )
    model = replace(model, camera=window(model.camera, distance_mm))
    scene = simulate.render(head, model.camera, pose, oversample=3)
    return list(simulate.frames(scene, model, frames, rng=rng))


def window(camera: Pinhole, distance_mm: float) -> Pinhole:
    """The part of a camera's image that a head before it covers, as a region of interest."""
    half_width, above, below = (
        int(mm / camera.pixel_mm(distance_mm)) for mm in (170.0, 190.0, 170.0)
    )
    left, top = max(int(camera.cx) - half_width, 0), max(int(camera.cy) - above, 0)
    right = min(int(camera.cx) + half_width, camera.width)
    bottom = min(int(camera.cy) + below, camera.height)
    return camera.crop(left, top, right - left, bottom - top)
