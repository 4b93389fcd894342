"""Recordings and folders of scans as sources; and the recorder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rangeface.errors import ParameterError, ScanError, ScanFault
from rangeface.io import FORMATS, read_recording, read_scan
from rangeface.io._mcap_writer import closing, messages, opening
from rangeface.sources._protocol import Closing, Frame
from rangeface.types import Camera, RangeImage

_BESIDE = {".toml", ".csv", ".txt", ".json", ".md", ".bmp"}  # what lies beside scans


class Recording(Closing):
    """An MCAP recording, read frame by frame.

    Parameters
    ----------
    path : str or Path
        The file.
    camera : Pinhole or Orthographic, optional
        Where the recording brings none.
    repeat : bool
        Begin again at the end; the time goes on.

    Raises
    ------
    ScanError
        The file is missing, no recording, or without a depth image (while it is read).
    """

    def __init__(
        self, path: str | Path, *, camera: Camera | None = None, repeat: bool = False
    ) -> None:
        self._path = Path(path)
        self._camera = camera
        self._repeat = repeat
        self._closed = False
        times = [t for _, (t, _) in zip(range(11), self._read(), strict=False)]
        self._rate_hz = (len(times) - 1) / times[-1] if times[-1:] > [0.0] else 30.0

    @property
    def name(self) -> str:
        """Its address."""
        return f"mcap:{self._path}"

    @property
    def rate_hz(self) -> float:
        """Of the first ten frames."""
        return self._rate_hz

    def close(self) -> None:
        """End before the next frame."""
        self._closed = True

    def _read(self) -> Iterator[tuple[float, RangeImage]]:
        return read_recording(self._path, camera=self._camera)

    def __iter__(self) -> Iterator[Frame]:
        number, start_s, time_s = 0, 0.0, 0.0
        while True:
            for logged_s, image in self._read():
                if self._closed:
                    return
                time_s = start_s + logged_s
                yield Frame(image, time_s, number)
                number += 1
            if number == 0:
                raise ScanError(self._path, ScanFault.NO_VALID_PIXELS, "no depth image in it")
            if not self._repeat:
                return
            start_s = time_s + 1.0 / self._rate_hz


class Folder(Closing):
    """The scans of a folder in the order of their names, as frames.

    Parameters
    ----------
    path : str or Path
        The folder.
    rate_hz : float
        Frames a second, > 0: files carry no time.
    camera : Pinhole or Orthographic, optional
        Where the scans bring none.

    Raises
    ------
    ScanError
        The folder is missing or holds no scan.
    ParameterError
        The rate is not > 0.
    """

    def __init__(
        self, path: str | Path, *, rate_hz: float = 30.0, camera: Camera | None = None
    ) -> None:
        if not rate_hz > 0:
            raise ParameterError(f"rate_hz: must be > 0, got {rate_hz}")
        self._path = Path(path)
        self._rate_hz = rate_hz
        self._camera = camera
        self._closed = False
        if not self._path.is_dir():
            raise ScanError(path, ScanFault.MISSING, "no such folder")
        self._files = sorted(
            file for file in self._path.iterdir()
            if file.is_file() and not file.name.startswith(".") and file.suffix not in _BESIDE
        )  # fmt: skip
        if not self._files:
            known = ", ".join(FORMATS)
            raise ScanError(path, ScanFault.NO_VALID_PIXELS, f"holds no scan; known are {known}")

    @property
    def name(self) -> str:
        """Its address."""
        return f"dir:{self._path}"

    @property
    def rate_hz(self) -> float:
        """As given."""
        return self._rate_hz

    def close(self) -> None:
        """End before the next file."""
        self._closed = True

    def __iter__(self) -> Iterator[Frame]:
        for number, file in enumerate(self._files):
            if self._closed:
                return
            yield Frame(read_scan(file, camera=self._camera), number / self._rate_hz, number)


class Recorder(Closing):
    """Writes frames to an MCAP recording as they come.

    Parameters
    ----------
    path : str or Path
        Ends in ``.mcap``; replaced if it exists.

    Raises
    ------
    ParameterError
        The ending is another, or a frame's camera is no pinhole.

    Notes
    -----
    Every frame is on its way to the disk when `write` returns: what a crash leaves is readable
    up to the tear. Depth, σ and amplitude are kept as float32.

    Examples
    --------
    >>> import tempfile
    >>> from rangeface.sources import Recorder, Recording, SyntheticCamera
    >>> path = Path(tempfile.mkdtemp()) / "two.mcap"
    >>> with Recorder(path) as recorder:
    ...     for _, frame in zip(range(2), SyntheticCamera("sr3000")):
    ...         recorder.write(frame)
    >>> [round(frame.time_s, 3) for frame in Recording(path)]
    [0.0, 0.033]
    """

    def __init__(self, path: str | Path) -> None:
        target = Path(path)
        if target.suffix.lower() != ".mcap":
            raise ParameterError(f"path: recordings are written as .mcap, not {target.suffix!r}")
        self._file = target.open("wb")
        self._file.write(opening())
        self._frames = 0

    @property
    def frames(self) -> int:
        """Frames written so far."""
        return self._frames

    def write(self, frame: Frame) -> None:
        """Append a frame."""
        self._file.write(messages(frame.image, frame.number, frame.time_s))
        self._file.flush()
        self._frames += 1

    def close(self) -> None:
        """End the recording."""
        if not self._file.closed:
            self._file.write(closing())
            self._file.close()
