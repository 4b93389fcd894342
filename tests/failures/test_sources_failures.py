"""Every Raises line of the sources, and cameras that are not there."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from rangeface import io, sources
from rangeface.errors import ParameterError, ScanError, SourceError
from rangeface.types import Orthographic, RangeImage


@pytest.mark.parametrize(
    "address", ["", "synthetic", "synthetic:", "tape:x", "realsense:first", "orbbec:x"]
)
def test_an_impossible_address(address):
    with pytest.raises(ParameterError, match="source"):
        sources.open_source(address)


def test_an_unknown_sensor():
    with pytest.raises(ParameterError, match="unknown preset"):
        sources.open_source("synthetic:sr9000")


@pytest.mark.parametrize("kind", ["mcap", "dir"])
def test_a_missing_file_or_folder(kind, tmp_path):
    with pytest.raises(ScanError, match="not found"):
        sources.open_source(f"{kind}:{tmp_path / 'none'}")


def test_a_folder_without_scans(tmp_path):
    (tmp_path / "camera.toml").write_text("")
    with pytest.raises(ScanError, match="holds no scan"):
        sources.Folder(tmp_path)


def test_no_recording(tmp_path):
    (tmp_path / "a.mcap").write_bytes(b"something else")
    with pytest.raises(ScanError, match="not an MCAP"):
        sources.Recording(tmp_path / "a.mcap")
    with pytest.raises(ScanError):
        sources.Recording(tmp_path)


def test_a_recording_without_a_depth_image(tmp_path):
    with sources.Recorder(tmp_path / "empty.mcap"):
        pass
    with pytest.raises(ScanError, match="no depth image"):
        list(sources.Recording(tmp_path / "empty.mcap"))
    assert list(io.read_recording(tmp_path / "empty.mcap")) == []


def test_the_recorder_refuses_other_endings_and_parallel_projection(tmp_path):
    with pytest.raises(ParameterError, match="mcap"):
        sources.Recorder(tmp_path / "a.bag")
    flat = RangeImage(np.ones((2, 2)), Orthographic(1.0, 0, 0, 2, 2))
    with (
        sources.Recorder(tmp_path / "a.mcap") as recorder,
        pytest.raises(ParameterError, match="pinhole"),
    ):
        recorder.write(sources.Frame(flat, 0.0, 0))


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: sources.Player(None, speed=0.0), "speed"),
        (lambda: sources.Newest(None, capacity=0), "capacity"),
        (lambda: sources.Reconnecting(None, wait_s=0.0), "wait_s"),
        (lambda: sources.Faults(drop=1.5), "drop"),
        (lambda: sources.Folder(".", rate_hz=0.0), "rate_hz"),
        (lambda: sources.SyntheticCamera("sr3000", rate_hz=0.0), "rate_hz"),
        (lambda: sources.SyntheticCamera("sr3000", []), "nobody"),
        (lambda: sources.comings_and_goings(None, []), "people"),
        (lambda: sources.comings_and_goings(None, [1], stay_s=1.0), "stay_s"),
        (lambda: sources.Walk(1, 0.0, 1.0, (0,) * 3, (0,) * 3, (0,) * 3), "stride_s"),
    ],
)
def test_numbers_out_of_range(make, name):
    with pytest.raises(ParameterError, match=name):
        make()


# ── devices, with the makers' libraries played by a few lines ────────────────────────────


@pytest.mark.parametrize(
    ("address", "module"), [("realsense:0", "pyrealsense2"), ("orbbec:0", "pyorbbecsdk")]
)
def test_a_camera_without_its_library(address, module, monkeypatch):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(SourceError, match=r"pip install 'rangeface\["):
        sources.open_source(address)


def fake_realsense(cameras=1, frames=3):
    """As much of pyrealsense2 as is called."""
    intrinsics = SimpleNamespace(fx=50.0, fy=50.0, ppx=1.5, ppy=1.0, width=4, height=3)
    given = iter(range(frames))

    def wait(_):
        k = next(given, None)
        if k is None:
            raise RuntimeError("Frame didn't arrive within 2000")
        raw = np.array([[0, 65535, 500, 600]] * 3, np.uint16)
        depth = SimpleNamespace(
            get_timestamp=lambda: 1000.0 + 33.0 * k,
            get_frame_number=lambda: 7 + k,
            get_data=lambda: raw,
        )
        return SimpleNamespace(get_depth_frame=lambda: depth)

    stream = SimpleNamespace(
        as_video_stream_profile=lambda: SimpleNamespace(get_intrinsics=lambda: intrinsics)
    )
    sensor = SimpleNamespace(get_depth_scale=lambda: 0.001)
    profile = SimpleNamespace(
        get_device=lambda: SimpleNamespace(first_depth_sensor=lambda: sensor),
        get_stream=lambda _: stream,
    )
    device = SimpleNamespace(get_info=lambda _: "123")
    return SimpleNamespace(
        context=lambda: SimpleNamespace(query_devices=lambda: [device] * cameras),
        config=lambda: SimpleNamespace(enable_device=lambda _: None, enable_stream=lambda *_: None),
        pipeline=lambda: SimpleNamespace(
            start=lambda _: profile, wait_for_frames=wait, stop=lambda: None
        ),
        camera_info=SimpleNamespace(serial_number=0),
        stream=SimpleNamespace(depth=0),
        format=SimpleNamespace(z16=0),
    )


def test_a_realsense_gives_millimetres_until_it_is_unplugged(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrealsense2", fake_realsense())
    stream = iter(sources.open_source("realsense:0"))
    frames = [next(stream) for _ in range(3)]
    assert [f.number for f in frames] == [0, 1, 2]
    assert frames[2].time_s == pytest.approx(0.066)
    assert np.allclose(frames[0].image.depth[0], [np.nan, np.nan, 500, 600], equal_nan=True)
    with pytest.raises(SourceError, match="didn't arrive"):
        next(stream)


def test_no_realsense_is_plugged_in(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrealsense2", fake_realsense(cameras=0))
    with pytest.raises(SourceError, match="0 RealSense cameras"):
        sources.open_source("realsense:0")


def fake_orbbec(cameras=1, frames=2):
    """As much of pyorbbecsdk as is called."""
    given = iter(range(frames))

    def wait(_):
        k = next(given, None)
        if k is None:
            return None
        depth = SimpleNamespace(
            get_timestamp=lambda: 50.0 * k,
            get_index=lambda: k,
            get_data=lambda: np.full(12, 400, np.uint16).tobytes(),
            get_width=lambda: 4,
            get_height=lambda: 3,
            get_depth_scale=lambda: 2.0,
        )
        return SimpleNamespace(get_depth_frame=lambda: depth)

    profile = SimpleNamespace(get_fps=lambda: 20)
    profiles = SimpleNamespace(get_default_video_stream_profile=lambda: profile)
    intrinsic = SimpleNamespace(fx=50.0, fy=50.0, cx=1.5, cy=1.0, width=4, height=3)
    devices = SimpleNamespace(
        get_count=lambda: cameras, get_device_by_index=lambda _: SimpleNamespace()
    )
    return SimpleNamespace(
        Context=lambda: SimpleNamespace(query_devices=lambda: devices),
        Pipeline=lambda _: SimpleNamespace(
            get_stream_profile_list=lambda _: profiles,
            start=lambda _: None,
            get_camera_param=lambda: SimpleNamespace(depth_intrinsic=intrinsic),
            wait_for_frames=wait,
            stop=lambda: None,
        ),
        Config=lambda: SimpleNamespace(enable_stream=lambda _: None),
        OBSensorType=SimpleNamespace(DEPTH_SENSOR=0),
    )


def test_an_orbbec_gives_millimetres_until_it_is_unplugged(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyorbbecsdk", fake_orbbec())
    with sources.open_source("orbbec:0") as camera:
        stream = iter(camera)
        frames = [next(stream), next(stream)]
        assert camera.rate_hz == 20.0
        assert frames[1].time_s == pytest.approx(0.05)
        assert (frames[0].image.depth == 800.0).all()
        with pytest.raises(SourceError, match="no frame"):
            next(stream)


def test_no_orbbec_is_plugged_in(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyorbbecsdk", fake_orbbec(cameras=0))
    with pytest.raises(SourceError, match="0 Orbbec cameras"):
        sources.open_source("orbbec:0")
