"""Tracking, accumulation over frames, counting: who stands before the camera."""

from rangeface.live._people import People, Person
from rangeface.live._recognizer import LiveRecognizer
from rangeface.live._transfer import Transfer, link_people, write_transfers
from rangeface.live._view import LiveFrame, TrackView
from rangeface.live._visits import Counts, Doorway, Visit, count_people, write_visits

__all__ = [
    "Counts",
    "Doorway",
    "LiveFrame",
    "LiveRecognizer",
    "People",
    "Person",
    "TrackView",
    "Transfer",
    "Visit",
    "count_people",
    "link_people",
    "write_transfers",
    "write_visits",
]
