"""Range images → an MCAP recording of ROS 2 messages, without a foreign library."""

from __future__ import annotations

import struct

import numpy as np

from rangeface.errors import ParameterError
from rangeface.types import Float32, Pinhole, RangeImage

MAGIC = b"\x89MCAP0\r\n"

_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _DATA_END = 1, 2, 3, 4, 5, 15

_HEADER_MSG = "std_msgs/Header header\n"
_HEADER_DEF = (
    f"{'=' * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)
_IMAGE_MSG = (
    _HEADER_MSG + "uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
    "uint32 step\nuint8[] data\n" + _HEADER_DEF
)
_INFO_MSG = (
    _HEADER_MSG + "uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\n"
    "float64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n"
    "sensor_msgs/RegionOfInterest roi\n" + _HEADER_DEF + f"{'=' * 80}\n"
    "MSG: sensor_msgs/RegionOfInterest\nuint32 x_offset\nuint32 y_offset\nuint32 height\n"
    "uint32 width\nbool do_rectify\n"
)


#: Topic of every channel, in the order of their numbers, and what its unit is in ours.
TOPICS = {
    "/depth/camera_info": 1.0,
    "/depth/image_raw": 1000.0,
    "/depth/sigma": 1000.0,
    "/depth/amplitude": 1.0,
}


def encode(images: list[RangeImage], *, rate_hz: float = 30.0) -> bytes:
    """A recording of depth images (32FC1, metres) and their cameras, as ROS 2 messages."""
    bodies = [messages(image, index, index / rate_hz) for index, image in enumerate(images)]
    return b"".join([opening(), *bodies, closing()])


def opening() -> bytes:
    """What stands before the messages: the magic, the schemas and the channels."""
    out = [MAGIC, _record(_HEADER, _text("ros2") + _text("rangeface"))]
    for number, (name, message) in enumerate((("CameraInfo", _INFO_MSG), ("Image", _IMAGE_MSG)), 1):
        schema = _text(f"sensor_msgs/msg/{name}") + _text("ros2msg") + _text(message)
        out.append(_record(_SCHEMA, struct.pack("<H", number) + schema))
    for number, topic in enumerate(TOPICS, 1):
        schema_number = struct.pack("<HH", number, 1 if topic.endswith("camera_info") else 2)
        channel = schema_number + _text(topic) + _text("cdr") + struct.pack("<I", 0)
        out.append(_record(_CHANNEL, channel))
    return b"".join(out)


def messages(image: RangeImage, index: int, time_s: float) -> bytes:
    """One frame: its camera, its σ and amplitude where it has them, and its depth.

    Raises
    ------
    ParameterError
        The camera is no pinhole.
    """
    if not isinstance(image.camera, Pinhole):
        raise ParameterError("image: a recording needs a pinhole camera")
    nanos = round(time_s * 1e9)
    planes = {"/depth/sigma": image.sigma, "/depth/amplitude": image.amplitude,
              "/depth/image_raw": image.depth}  # fmt: skip
    bodies = [("/depth/camera_info", _info_body(image.camera, nanos))]
    bodies += [
        (topic, _image_body(plane / np.float32(TOPICS[topic]), nanos))
        for topic, plane in planes.items()
        if plane is not None
    ]
    numbers = {topic: number for number, topic in enumerate(TOPICS, 1)}
    return b"".join(
        _record(
            _MESSAGE,
            struct.pack("<HIQQ", numbers[topic], index, nanos, nanos) + b"\0\1\0\0" + body,
        )
        for topic, body in bodies
    )


def closing() -> bytes:
    """What ends a recording."""
    end = _record(_DATA_END, struct.pack("<I", 0))
    return end + _record(_FOOTER, struct.pack("<QQI", 0, 0, 0)) + MAGIC


def _record(kind: int, body: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(body)) + body


def _text(text: str, *, ending: bytes = b"") -> bytes:
    data = text.encode() + ending
    return struct.pack("<I", len(data)) + data


def _padded(data: bytes, size: int) -> bytes:
    return data + bytes(-len(data) % size)


def _message_header(nanos: int) -> bytes:
    stamp = struct.pack("<iI", nanos // 10**9, nanos % 10**9)
    return _padded(stamp + _text("depth", ending=b"\0"), 4)


def _image_body(plane: Float32, nanos: int) -> bytes:
    height, width = plane.shape
    head = _message_header(nanos) + struct.pack("<II", height, width)
    head = _padded(head + _text("32FC1", ending=b"\0") + b"\0", 4)
    data = plane.astype("<f4").tobytes()
    return head + struct.pack("<II", 4 * width, len(data)) + data


def _info_body(camera: Pinhole, nanos: int) -> bytes:
    head = _message_header(nanos) + struct.pack("<II", camera.height, camera.width)
    head = _padded(head + _text("plumb_bob", ending=b"\0"), 4) + struct.pack("<I", 0)
    k = [camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1]
    p = [camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0]
    numbers = struct.pack("<30d", *k, *np.eye(3).ravel(), *p)
    return _padded(head, 8) + numbers + struct.pack("<IIIIII?", 0, 0, 0, 0, 0, 0, False)
