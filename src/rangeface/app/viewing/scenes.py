"""What the demonstration shows: friends who are enrolled, and strangers who are not."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rangeface import sensors
from rangeface.gallery import MemoryGallery
from rangeface.recognizer import FaceRecognizer
from rangeface.sources import Player, Source, SyntheticCamera, Walk, enrolment

SENSOR, RATE_HZ = "sr3000", 20.0
#: Number of a synthetic head → its name. The people do not exist.
FRIENDS = {0: "Ada", 1: "Bruno", 2: "Chiara", 3: "Dana", 4: "Emil", 5: "Farah"}
STRANGERS = (900, 901)

_ALONE_MM, _PAIR_MM, _APART_MM, _OUTSIDE_MM = 430.0, 470.0, 115.0, 420.0


def friends(recognizer: FaceRecognizer) -> MemoryGallery:
    """A gallery of all friends, each enrolled from ten frames on another day."""
    gallery = MemoryGallery()
    for person, name in FRIENDS.items():
        trace = recognizer.pipeline.trace(enrolment(SENSOR, person))
        gallery.enroll(name, recognizer.template(trace, augment=True))
    return gallery


def _alone(person: int, start_s: float, stop_s: float) -> Walk:
    return Walk(
        person, start_s, stop_s, (0.0, 0.0, _ALONE_MM), (-_OUTSIDE_MM, 0.0, _ALONE_MM),
        (_OUTSIDE_MM, 0.0, _ALONE_MM),
    )  # fmt: skip


def _beside(person: int, start_s: float, stop_s: float, side: float) -> Walk:
    outside = (side * (_OUTSIDE_MM + _APART_MM), 0.0, _PAIR_MM)
    return Walk(person, start_s, stop_s, (side * _APART_MM, 0.0, _PAIR_MM), outside, outside)


def people_come_and_go() -> tuple[Walk, ...]:
    """A friend, a stranger who stays, two friends together, another friend, and so on."""
    return (
        _alone(0, 0.0, 9.0),
        _alone(STRANGERS[0], 9.5, 27.5),
        _beside(1, 28.0, 38.0, -1.0),
        _beside(2, 29.0, 38.5, +1.0),
        _alone(3, 39.0, 47.0),
    )


def a_stranger_stays() -> tuple[Walk, ...]:
    """Somebody to enrol, with all the time one needs."""
    return (_alone(STRANGERS[1], 0.0, 36.0),)


#: Address → what it is called, and who walks there.
SCENES: Mapping[str, tuple[str, Callable[[], tuple[Walk, ...]]]] = {
    "synthetic:comings-and-goings": ("Passers-by", people_come_and_go),
    "synthetic:stranger": ("A stranger", a_stranger_stays),
}


def open_scene(address: str) -> Source:
    """The synthetic camera before a scene, at its own speed."""
    walks = SCENES[address][1]()
    return Player(SyntheticCamera(sensors.preset(SENSOR), walks, rate_hz=RATE_HZ))
