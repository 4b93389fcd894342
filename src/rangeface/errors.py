"""What can go wrong, by kind: one class a kind, one line a message, the remedy in it."""

from __future__ import annotations

from enum import StrEnum
from os import PathLike


class RangeFaceError(Exception):
    """Base of everything that rangeface raises for a user's mistake or a broken input."""


class ParameterError(RangeFaceError, ValueError):
    """A parameter is outside its range; the message names the parameter."""


class UnitError(RangeFaceError, ValueError):
    """A unit is unknown or missing; nothing is guessed."""


class NoFaceError(RangeFaceError):
    """An image holds no face where one was needed; the message says why."""


class DegenerateError(RangeFaceError, ValueError):
    """The data do not determine what was asked: too few points, collinear, one class, …"""


class GalleryError(RangeFaceError):
    """A gallery cannot do what was asked: other fingerprint, unknown person, read-only file, …"""


class SourceError(RangeFaceError):
    """A camera is missing, has been unplugged or has stopped to answer; the message names it."""


class ScanFault(StrEnum):
    """The closed list of reasons for which a scan file is refused."""

    MISSING = "file not found"
    UNREADABLE = "file cannot be read"
    UNKNOWN_FORMAT = "unknown format"
    TRUNCATED = "file is truncated"
    MALFORMED = "file is malformed"
    TOO_LARGE = "file exceeds a limit"
    WRONG_SIZE = "wrong size"
    UNKNOWN_UNIT = "unknown unit"
    BAD_CAMERA = "bad camera"
    NO_VALID_PIXELS = "no valid pixels"
    UNSUPPORTED = "unsupported feature"


class ScanError(RangeFaceError):
    """A scan file is refused: one line that names the file, the fault and the detail.

    Parameters
    ----------
    path : str or PathLike
        The file.
    fault : ScanFault
        Reason from the closed list.
    detail : str
        What is wrong, with the numbers, and the remedy.
    """

    def __init__(self, path: str | PathLike[str], fault: ScanFault, detail: str = "") -> None:
        self.path = str(path)
        self.fault = fault
        self.detail = " ".join(detail.split())
        super().__init__(f"{self.path}: {fault.value}" + (f": {self.detail}" if detail else ""))

    def __reduce__(self) -> tuple[type[ScanError], tuple[str, ScanFault, str]]:
        return type(self), (self.path, self.fault, self.detail)
