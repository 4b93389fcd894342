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
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError, ScanFault
from rangeface.io import png16
from rangeface.io._mcap_writer import MAGIC
from rangeface.io._source import Source
from rangeface.io.camera_toml import depth_image
from rangeface.types import Pinhole, RangeImage

_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 3, 4, 5, 6
_DEPTH = {"16UC1": ("u2", "mm"), "mono16": ("u2", "mm"), "32FC1": ("f4", "m")}
_SECONDS = 10


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
    cameras: dict[tuple[int, int], Pinhole] = {}
    waiting: list[tuple[NDArray[np.generic], str]] = []
    for channel, message in _messages(source):
        try:
            if channel.kind == "CameraInfo":
                camera = _camera_info(_Cursor(message, channel.ros1))
                if camera is not None:
                    cameras.setdefault((camera.width, camera.height), camera)
                    ready = [w for w in waiting if w[0].shape == (camera.height, camera.width)]
                    waiting = [w for w in waiting if w[0].shape != (camera.height, camera.width)]
                    for raw, unit in ready:
                        yield depth_image(source, raw, unit=unit, camera=camera)
                continue
            found = _READERS[channel.kind](source, _Cursor(message, channel.ros1))
        except _TornError:
            raise source.error(ScanFault.TRUNCATED, f"a message of {channel.topic}") from None
        if found is None:
            continue
        key = (found[0].shape[1], found[0].shape[0])
        if source.camera is not None or key in cameras:
            yield depth_image(source, found[0], unit=found[1], camera=cameras.get(key))
        elif len(waiting) < 8:  # the camera's message may come a little later
            waiting.append(found)
    for raw, unit in waiting:
        yield depth_image(source, raw, unit=unit)


# ── records ──────────────────────────────────────────────────────────────────────────────


def _messages(source: Source) -> Iterator[tuple[_Channel, memoryview]]:
    schemas: dict[int, str] = {}
    channels: dict[int, _Channel] = {}
    for kind, body in _records(source, memoryview(source.data)[len(MAGIC) :], nested=False):
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
                cursor.skip(20)
                if channel is not None:
                    yield channel, cursor.rest()
        except _TornError:
            return


def _records(source: Source, data: memoryview, *, nested: bool) -> Iterator[tuple[int, memoryview]]:
    at = 0
    while at + 9 <= len(data):
        kind, size = struct.unpack_from("<BQ", data, at)
        if size > len(data) - at - 9:
            return  # the tear
        body = data[at + 9 : at + 9 + size]
        if kind == _CHUNK and not nested:
            yield from _records(source, _chunk(source, body), nested=True)
        else:
            yield kind, body
        at += 9 + size


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
