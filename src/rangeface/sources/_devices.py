"""Depth cameras on the desk; their makers' libraries are optional extras."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from threading import Event
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import SourceError
from rangeface.sources._protocol import Closing, Frame
from rangeface.types import Pinhole, RangeImage

#: A camera that gives no frame for so long counts as gone.
_PATIENCE_MS = 2000


class RealSense(Closing):
    """An Intel RealSense camera.

    Parameters
    ----------
    number : int
        Which of those that are plugged in, from 0.
    width, height, rate_hz : int
        Of the depth stream.

    Raises
    ------
    SourceError
        `pyrealsense2` is not installed, no such camera is plugged in, or it stops to answer.
    """

    def __init__(
        self, number: int = 0, *, width: int = 640, height: int = 480, rate_hz: int = 30
    ) -> None:
        self._rs = _library("pyrealsense2", "realsense")
        self.name = f"realsense:{number}"
        self.rate_hz = float(rate_hz)
        devices = self._rs.context().query_devices()
        if number >= len(devices):
            raise SourceError(f"{self.name}: {len(devices)} RealSense cameras are plugged in")
        config = self._rs.config()
        config.enable_device(devices[number].get_info(self._rs.camera_info.serial_number))
        config.enable_stream(self._rs.stream.depth, width, height, self._rs.format.z16, rate_hz)
        self._pipeline = self._rs.pipeline()
        try:
            profile = self._pipeline.start(config)
        except RuntimeError as failure:
            raise SourceError(f"{self.name}: {failure}") from failure
        self._scale_mm = 1e3 * profile.get_device().first_depth_sensor().get_depth_scale()
        k = profile.get_stream(self._rs.stream.depth).as_video_stream_profile().get_intrinsics()
        self._camera = Pinhole(k.fx, k.fy, k.ppx, k.ppy, k.width, k.height)
        self._closed = Event()

    def close(self) -> None:
        """Stop the stream."""
        if not self._closed.is_set():
            self._closed.set()
            self._pipeline.stop()

    def __iter__(self) -> Iterator[Frame]:
        first: tuple[float, int] | None = None
        while not self._closed.is_set():
            try:
                depth = self._pipeline.wait_for_frames(_PATIENCE_MS).get_depth_frame()
            except RuntimeError as failure:
                if self._closed.is_set():
                    return
                raise SourceError(f"{self.name}: {failure}") from failure
            stamp_s, count = depth.get_timestamp() / 1e3, depth.get_frame_number()
            first = first or (stamp_s, count)
            image = _image(np.asanyarray(depth.get_data()), self._scale_mm, self._camera)
            yield Frame(image, stamp_s - first[0], count - first[1])


class Orbbec(Closing):
    """An Orbbec camera: Femto, Gemini, Astra.

    Parameters
    ----------
    number : int
        Which of those that are plugged in, from 0.

    Raises
    ------
    SourceError
        `pyorbbecsdk` is not installed, no such camera is plugged in, or it stops to answer.
    """

    def __init__(self, number: int = 0) -> None:
        self._ob = _library("pyorbbecsdk", "orbbec")
        self.name = f"orbbec:{number}"
        devices = self._ob.Context().query_devices()
        if number >= devices.get_count():
            raise SourceError(f"{self.name}: {devices.get_count()} Orbbec cameras are plugged in")
        self._pipeline = self._ob.Pipeline(devices.get_device_by_index(number))
        profiles = self._pipeline.get_stream_profile_list(self._ob.OBSensorType.DEPTH_SENSOR)
        profile = profiles.get_default_video_stream_profile()
        self.rate_hz = float(profile.get_fps())
        config = self._ob.Config()
        config.enable_stream(profile)
        self._pipeline.start(config)
        k = self._pipeline.get_camera_param().depth_intrinsic
        self._camera = Pinhole(k.fx, k.fy, k.cx, k.cy, k.width, k.height)
        self._closed = Event()

    def close(self) -> None:
        """Stop the stream."""
        if not self._closed.is_set():
            self._closed.set()
            self._pipeline.stop()

    def __iter__(self) -> Iterator[Frame]:
        first: tuple[float, int] | None = None
        while not self._closed.is_set():
            frames = self._pipeline.wait_for_frames(_PATIENCE_MS)
            depth = None if frames is None else frames.get_depth_frame()
            if depth is None:
                if self._closed.is_set():
                    return
                raise SourceError(f"{self.name}: no frame for {_PATIENCE_MS / 1e3:g} s")
            stamp_s, count = depth.get_timestamp() / 1e3, depth.get_index()
            first = first or (stamp_s, count)
            raw = np.frombuffer(depth.get_data(), np.uint16)
            raw = raw.reshape(depth.get_height(), depth.get_width())
            image = _image(raw, float(depth.get_depth_scale()), self._camera)
            yield Frame(image, stamp_s - first[0], count - first[1])


def _image(raw: NDArray[np.uint16], scale_mm: float, camera: Pinhole) -> RangeImage:
    """Depth in the device's steps → range image; 0 and 65535 are invalid."""
    depth = raw.astype(np.float32) * np.float32(scale_mm)
    return RangeImage(np.where((raw > 0) & (raw < 65535), depth, np.nan), camera)


def _library(module: str, extra: str) -> ModuleType | Any:
    try:
        return import_module(module)
    except ImportError as failure:
        raise SourceError(
            f"{extra}: needs the maker's library: pip install 'rangeface[{extra}]'"
        ) from failure
