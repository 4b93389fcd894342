"""Recordings that onlookers begin and end."""

from __future__ import annotations

from datetime import datetime
from itertools import count
from pathlib import Path
from threading import Lock
from typing import Any

from rangeface.sources import Frame, Recorder


class Recordings:
    """At most one recording at a time, in a folder, named after the time of its beginning.

    Parameters
    ----------
    folder : Path
        Made where it is missing.

    Notes
    -----
    May be used from any thread.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._open: tuple[Path, Recorder] | None = None
        self._lock = Lock()

    def begin(self) -> None:
        """Record from now on, unless it does already."""
        with self._lock:
            if self._open is None:
                self._folder.mkdir(parents=True, exist_ok=True)
                path = self._new()
                self._open = path, Recorder(path)

    def write(self, frame: Frame) -> None:
        """Append a frame, where a recording is open."""
        with self._lock:
            if self._open is not None:
                self._open[1].write(frame)

    def end(self) -> None:
        """Close the recording, if there is one."""
        with self._lock:
            if self._open is not None:
                self._open[1].close()
                self._open = None

    def as_dict(self) -> dict[str, Any] | None:
        """For the page: file and frames so far; None where nothing is recorded."""
        with self._lock:
            if self._open is None:
                return None
            path, recorder = self._open
            return {"file": path.name, "frames": recorder.frames}

    def _new(self) -> Path:
        """A name that no file has."""
        stem = f"rangeface-{datetime.now():%Y%m%d-%H%M%S}"
        paths = (self._folder / f"{stem}{f'-{k}' if k else ''}.mcap" for k in count())
        return next(path for path in paths if not path.exists())
