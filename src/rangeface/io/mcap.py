"""MCAP recordings of depth images: ROS 2 (CDR) and ROS 1 messages.

sensor_msgs/Image in 16UC1 or mono16 is depth in mm, in 32FC1 metres (REP 118); a
sensor_msgs/CompressedImage is read where its format says 16UC1 and compressedDepth (twelve
bytes, then a PNG). The intrinsics come from a sensor_msgs/CameraInfo of the same size. A torn
recording is read up to the tear. Chunks in Zstandard or LZ4 need the extra ``mcap`` and are
expanded in a process of their own.
"""

from __future__ import annotations

import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError, ScanFault
from rangeface.io import png16
from rangeface.io._mcap_writer import MAGIC, TOPICS
from rangeface.io._source import Limits, Source
from rangeface.io.camera_toml import depth_image
from rangeface.types import Camera, Float32, Pinhole, RangeImage

_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 3, 4, 5, 6
_DEPTH = {"16UC1": ("u2", "mm"), "mono16": ("u2", "mm"), "32FC1": ("f4", "m")}
_SECONDS = 10
#: Images that are no depth, by the last part of their topic, and what their unit is in ours.
_PLANES_MM = {"sigma": TOPICS["/depth/sigma"], "amplitude": TOPICS["/depth/amplitude"]}


class _TornError(Exception):
    """A record runs past the end of what is there."""


@dataclass
class _Channel:
    kind: str
    topic: str
    ros1: bool


def recognise(source: Source) -> bool:
    """The eight bytes that open every recording."""
    return source.data.startswith(MAGIC)


def parse(source: Source) -> RangeImage:
    """The first depth image."""
    for image in frames(source):
        return image
    raise source.error(ScanFault.NO_VALID_PIXELS, "no depth image (16UC1, mono16, 32FC1) in it")


def frames(source: Source) -> Iterator[RangeImage]:
    """All depth images in the order of the recording, up to a tear."""
    for _, image in timed_frames(source, BytesIO(source.data)):
        yield image


def read_recording(
    path: str | Path,
    *,
    camera: Camera | None = None,
    unit: str | None = None,
    limits: Limits | None = None,
) -> Iterator[tuple[float, RangeImage]]:
    """Read an MCAP recording of any length, frame by frame, with σ and amplitude if it has them.

    Parameters
    ----------
    path : str or Path
        The recording; it is not held in memory.
    camera, unit
        As in `read_scan`.
    limits : Limits, optional
        `max_bytes` caps a record, not the file.

    Yields
    ------
    time_s : float
        When the frame was logged, s since the first one.
    image : RangeImage
        One without a valid pixel included. A torn recording ends at the tear.

    Raises
    ------
    ScanError
        The file is missing or no recording, or a message is broken.
    """
    source = Source(Path(path), b"", limits or Limits(), camera, unit)
    try:
        stream = source.path.open("rb")
    except FileNotFoundError:
        raise source.error(ScanFault.MISSING, "") from None
    except OSError as fault:
        raise source.error(ScanFault.UNREADABLE, str(fault)) from None
    with stream:
        if stream.read(len(MAGIC)) != MAGIC:
            raise source.error(ScanFault.UNKNOWN_FORMAT, "not an MCAP recording")
        stream.seek(0)
        yield from timed_frames(source, stream)


def timed_frames(source: Source, stream: BinaryIO) -> Iterator[tuple[float, RangeImage]]:
    """Seconds since the first depth image, and every depth image."""
    gathered = _Gathered(source)
    first = None
    for channel, nanos, message in _messages(source, stream):
        try:
            ready = gathered.take(channel, nanos, message)
        except _TornError:
            raise source.error(ScanFault.TRUNCATED, f"a message of {channel.topic}") from None
        for stamp, image in ready:
            first = stamp if first is None else first
            yield (stamp - first) / 1e9, image
    for stamp, image in gathered.rest():
        first = stamp if first is None else first
        yield (stamp - first) / 1e9, image


class _Pixels(NamedTuple):
    """A depth image that has not met its camera yet."""

    nanos: int
    raw: NDArray[np.generic]
    unit: str


class _Gathered:
    """Brings a depth image together with its camera, its σ and its amplitude."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._cameras: dict[tuple[int, ...], Pinhole] = {}
        self._waiting: list[_Pixels] = []
        self._planes: dict[str, tuple[int, NDArray[np.generic] | None]] = {}

    def take(
        self, channel: _Channel, nanos: int, message: memoryview
    ) -> list[tuple[int, RangeImage]]:
        """The depth images that a message completes."""
        cursor = _Cursor(message, channel.ros1)
        if channel.kind == "CameraInfo":
            return self._met(_camera_info(cursor))
        found = _READERS[channel.kind](self._source, cursor)
        if found is None:
            return []
        plane = channel.topic.rpartition("/")[2]
        if plane in _PLANES_MM:  # they come just before the depth that they belong to
            self._planes[plane] = nanos, found[0]
            return []
        pixels = _Pixels(nanos, *found)
        if self._source.camera is not None or pixels.raw.shape in self._cameras:
            return [self._image(pixels)]
        if len(self._waiting) < 8:  # the camera's message may come a little later
            self._waiting.append(pixels)
        return []

    def rest(self) -> list[tuple[int, RangeImage]]:
        """The depth images that no camera came for: a camera file may stand beside them."""
        return [self._image(pixels) for pixels in self._waiting]

    def _met(self, camera: Pinhole | None) -> list[tuple[int, RangeImage]]:
        if camera is None:
            return []
        shape = camera.height, camera.width
        self._cameras.setdefault(shape, camera)
        ready = [p for p in self._waiting if p.raw.shape == shape]
        self._waiting = [p for p in self._waiting if p.raw.shape != shape]
        return [self._image(pixels) for pixels in ready]

    def _image(self, pixels: _Pixels) -> tuple[int, RangeImage]:
        camera = self._cameras.get(pixels.raw.shape)
        image = depth_image(self._source, pixels.raw, unit=pixels.unit, camera=camera)
        return pixels.nanos, replace(
            image,
            sigma=self._plane("sigma", pixels.nanos, image.shape),
            amplitude=self._plane("amplitude", pixels.nanos, image.shape),
        )

    def _plane(self, name: str, nanos: int, shape: tuple[int, int]) -> Float32 | None:
        """What came for that moment, if it fits."""
        stamp, plane = self._planes.get(name, (-1, None))
        if plane is None or stamp != nanos or plane.shape != shape:
            return None
        return plane.astype(np.float32) * np.float32(_PLANES_MM[name])


# ── records ──────────────────────────────────────────────────────────────────────────────


def _messages(source: Source, stream: BinaryIO) -> Iterator[tuple[_Channel, int, memoryview]]:
    schemas: dict[int, str] = {}
    channels: dict[int, _Channel] = {}
    stream.seek(len(MAGIC))
    for kind, body in _records(source, stream, nested=False):
        try:
            cursor = _Cursor(body, ros1=True)
            if kind == _SCHEMA:
                number = cursor.number("H")
                schemas[number] = cursor.text()
            elif kind == _CHANNEL:
                number, schema = cursor.number("H"), cursor.number("H")
                name = schemas.get(schema, "").rsplit("/", 1)[-1]
                topic, encoding = cursor.text(), cursor.text()
                if name in _READERS and encoding in ("cdr", "ros1"):
                    channels[number] = _Channel(name, topic, encoding == "ros1")
            elif kind == _MESSAGE:
                channel = channels.get(cursor.number("H"))
                cursor.skip(4)
                nanos = cursor.number("Q")
                cursor.skip(8)
                if channel is not None:
                    yield channel, nanos, cursor.rest()
        except _TornError:
            return


def _records(source: Source, stream: BinaryIO, *, nested: bool) -> Iterator[tuple[int, memoryview]]:
    while len(head := stream.read(9)) == 9:
        kind, size = struct.unpack("<BQ", head)
        if size > source.limits.max_bytes:
            return  # no record of ours: the tear
        body = stream.read(size)
        if len(body) < size:
            return  # the tear
        if kind == _CHUNK and not nested:
            yield from _records(source, BytesIO(_chunk(source, memoryview(body))), nested=True)
        else:
            yield kind, memoryview(body)


def _chunk(source: Source, body: memoryview) -> memoryview:
    cursor = _Cursor(body, ros1=True)
    try:
        cursor.skip(16)
        expanded = cursor.number("Q")
        cursor.skip(4)
        packing = cursor.text()
        cursor.skip(8)
    except _TornError:
        return memoryview(b"")
    packed = cursor.rest()
    if packing == "":
        return packed
    if packing not in ("zstd", "lz4"):
        raise source.error(ScanFault.UNSUPPORTED, f"chunks in {packing[:20]!r}")
    if expanded > source.limits.expanded(len(packed)):
        raise source.error(ScanFault.TOO_LARGE, f"a chunk expands to {expanded} bytes")
    return memoryview(_expand(source, packing, bytes(packed), expanded))


def _expand(source: Source, packing: str, packed: bytes, size: int) -> bytes:
    """Expand in a process of its own, which has a limit of memory and of time."""
    worker = [sys.executable, "-I", str(Path(__file__).with_name("_worker.py")), packing, str(size)]
    try:
        done = subprocess.run(
            worker, input=packed, capture_output=True, timeout=_SECONDS, check=False
        )
    except (subprocess.TimeoutExpired, OSError) as fault:
        raise source.error(ScanFault.UNREADABLE, f"{packing}: {fault}") from None
    if done.returncode == 3:
        raise source.error(
            ScanFault.UNSUPPORTED, f"chunks in {packing}: install rangeface[mcap] to read them"
        )
    if done.returncode or len(done.stdout) != size:
        raise source.error(ScanFault.MALFORMED, f"a chunk in {packing} cannot be expanded")
    return done.stdout


# ── messages ─────────────────────────────────────────────────────────────────────────────


class _Cursor:
    """Reads little-endian values; CDR aligns them to their size, ROS 1 does not."""

    def __init__(self, data: memoryview, ros1: bool) -> None:
        self.data = data if ros1 else data[4:]  # behind the encapsulation header
        self.order = "<" if ros1 or bytes(data[1:2]) != b"\0" else ">"
        self.ros1 = ros1
        self.at = 0

    def skip(self, size: int) -> memoryview:
        if size > len(self.data) - self.at:
            raise _TornError
        self.at += size
        return self.data[self.at - size : self.at]

    def number(self, kind: str) -> int:
        size = struct.calcsize(kind)
        if not self.ros1:
            self.skip(-self.at % size)
        return int(struct.unpack(self.order + kind, self.skip(size))[0])

    def floats(self, count: int) -> NDArray[np.float64]:
        if not self.ros1:
            self.skip(-self.at % 8 if count else 0)
        return np.frombuffer(self.skip(8 * count), self.order + "f8").astype(np.float64)

    def text(self) -> str:
        return bytes(self.skip(self.number("I"))).rstrip(b"\0").decode("utf-8", "replace")

    def header(self) -> None:
        """Pass over a std_msgs/Header."""
        for kind in "III" if self.ros1 else "iI":
            self.number(kind)
        self.text()

    def rest(self) -> memoryview:
        return self.data[self.at :]


def _compressed(source: Source, cursor: _Cursor) -> tuple[NDArray[np.generic], str] | None:
    """Pixels and unit of a compressed 16-bit depth image, None where it is none."""
    cursor.header()
    words = cursor.text()
    data = cursor.skip(cursor.number("I"))
    if not ("compressedDepth" in words and "16UC1" in words):
        return None
    return png16.pixels(replace(source, data=bytes(data[12:]))), "mm"


def _image(source: Source, cursor: _Cursor) -> tuple[NDArray[np.generic], str] | None:
    """Pixels and unit of an Image, None where it is no depth image."""
    cursor.header()
    height, width = cursor.number("I"), cursor.number("I")
    encoding = cursor.text()
    big, step = cursor.number("B"), cursor.number("I")
    data = cursor.skip(cursor.number("I"))
    if encoding not in _DEPTH:
        return None
    source.cap_pixels(width, height)
    kind, unit = _DEPTH[encoding]
    dtype = np.dtype((">" if big else "<") + kind)
    if step < width * dtype.itemsize or step * (height - 1) + width * dtype.itemsize > len(data):
        raise source.error(
            ScanFault.WRONG_SIZE, f"{len(data)} bytes for {width} × {height} px, {step} bytes a row"
        )
    rows: NDArray[np.generic] = np.ndarray(
        (height, width), dtype, bytes(data), 0, (step, dtype.itemsize)
    )
    return rows.astype(dtype.newbyteorder("=")), unit


def _camera_info(cursor: _Cursor) -> Pinhole | None:
    """Intrinsics of a CameraInfo; None where it is not calibrated."""
    cursor.header()
    height, width = cursor.number("I"), cursor.number("I")
    cursor.text()
    cursor.floats(cursor.number("I"))
    K = cursor.floats(9)
    try:
        return Pinhole(float(K[0]), float(K[4]), float(K[2]), float(K[5]), width, height)
    except ParameterError:
        return None


_READERS: dict[str, Callable[[Source, _Cursor], tuple[NDArray[np.generic], str] | None]] = {
    "Image": _image,
    "CompressedImage": _compressed,
    "CameraInfo": lambda source, cursor: None,
}
