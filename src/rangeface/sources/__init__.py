"""Cameras, recordings, the synthetic camera: iterators of frames."""

from __future__ import annotations

from rangeface.errors import ParameterError
from rangeface.sources._devices import Orbbec, RealSense
from rangeface.sources._faulty import Faults, Faulty
from rangeface.sources._newest import Newest
from rangeface.sources._player import Player
from rangeface.sources._protocol import Frame, Seen, Source
from rangeface.sources._reconnecting import Reconnecting
from rangeface.sources._recording import Folder, Recorder, Recording
from rangeface.sources._script import Walk, comings_and_goings
from rangeface.sources._synthetic import SyntheticCamera, enrolment

_KINDS = "synthetic:SENSOR, mcap:FILE, dir:FOLDER, realsense:NUMBER, orbbec:NUMBER"


def open_source(
    address: str, *, speed: float | None = 1.0, repeat: bool = False, rate_hz: float | None = None
) -> Source:
    """Open a source by its address.

    Parameters
    ----------
    address : str
        ``synthetic:sr3000`` (any preset of `rangeface.sensors`), ``mcap:FILE``, ``dir:FOLDER``,
        ``realsense:0`` or ``orbbec:0``.
    speed : float, optional
        Of a recording, a folder or the synthetic camera: 1 is its own speed; None: each frame as
        soon as it is asked for.
    repeat : bool
        Begin a recording again at its end. The synthetic camera never ends.
    rate_hz : float, optional
        Frames a second of the synthetic camera and of a folder. Default: 30.

    Returns
    -------
    Source
        Frames in the order of their capture; `Newest` puts a thread between.

    Raises
    ------
    ParameterError
        The address is of no known kind, or a number is out of range.
    SourceError
        A camera's library is not installed, or the camera is not plugged in.
    ScanError
        A file or folder is missing or broken.

    Examples
    --------
    >>> with open_source("synthetic:sr3000", speed=None) as camera:
    ...     frame = next(iter(camera))
    >>> frame.image.shape
    (144, 176)
    """
    kind, separator, rest = address.partition(":")
    if not separator or not rest:
        raise ParameterError(f"source: {address!r} is no address; write one of {_KINDS}")
    if kind == "synthetic":
        return Player(SyntheticCamera(rest, rate_hz=rate_hz or 30.0), speed=speed)
    if kind == "mcap":
        return Player(Recording(rest, repeat=repeat), speed=speed)
    if kind == "dir":
        return Player(Folder(rest, rate_hz=rate_hz or 30.0), speed=speed)
    if kind in ("realsense", "orbbec"):
        if not rest.isdecimal():
            raise ParameterError(f"source: {address!r}: the camera's number must follow the colon")
        return RealSense(int(rest)) if kind == "realsense" else Orbbec(int(rest))
    raise ParameterError(f"source: unknown kind {kind!r}; known: {_KINDS}")


__all__ = [
    "Faults",
    "Faulty",
    "Folder",
    "Frame",
    "Newest",
    "Orbbec",
    "Player",
    "RealSense",
    "Reconnecting",
    "Recorder",
    "Recording",
    "Seen",
    "Source",
    "SyntheticCamera",
    "Walk",
    "comings_and_goings",
    "enrolment",
    "open_source",
]
