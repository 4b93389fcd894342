"""What every source keeps, whatever stands behind it."""

import numpy as np
import pytest

from rangeface import io, sources
from rangeface.sources import Folder, Newest, Player, Reconnecting, Recorder, Recording
from rangeface.types import Pinhole, RangeImage

CAMERA = Pinhole(50.0, 50.0, 7.5, 5.5, 16, 12)


def frames(count=6, rate_hz=30.0):
    for k in range(count):
        depth = np.full((12, 16), 500.0 + k, np.float32)
        depth[0, 0] = np.nan
        image = RangeImage(depth, CAMERA, sigma=depth / 100, amplitude=depth * 3)
        yield sources.Frame(image, k / rate_hz, k)


class Listed(sources._protocol.Closing):
    """A source of given frames."""

    name, rate_hz = "listed", 30.0

    def __init__(self, given):
        self.given = given

    def __iter__(self):
        return iter(self.given)


@pytest.fixture
def recording(tmp_path):
    with Recorder(tmp_path / "six.mcap") as recorder:
        for frame in frames():
            recorder.write(frame)
    return tmp_path / "six.mcap"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scans").mkdir()
    for frame in frames():
        io.write_scan(tmp_path / "scans" / f"{frame.number:03}.npz", frame.image)
    return tmp_path / "scans"


@pytest.fixture(
    params=["recording", "folder", "synthetic", "player", "newest", "reconnecting", "faulty"]
)
def source(request, recording, folder):
    return {
        "recording": lambda: Recording(recording),
        "folder": lambda: Folder(folder),
        "synthetic": lambda: sources.SyntheticCamera("sr3000", keep=False),
        "player": lambda: Player(Recording(recording), speed=None),
        "newest": lambda: Newest(Recording(recording), capacity=6),
        "reconnecting": lambda: Reconnecting(lambda: Recording(recording)),
        "faulty": lambda: sources.Faulty(Recording(recording), sources.Faults()),
    }[request.param]()


def test_frames_come_in_order_with_a_camera_and_the_time(source):
    with source:
        got = [frame for _, frame in zip(range(6), source, strict=False)]
    assert [frame.number for frame in got] == list(range(6))
    assert np.allclose(np.diff([frame.time_s for frame in got]), 1 / 30, atol=1e-6)
    assert all(frame.image.shape == got[0].image.shape for frame in got)
    assert source.name
    assert source.rate_hz == pytest.approx(30.0)


def test_a_source_may_be_closed_twice_and_then_ends(source):
    seen = []
    for frame in source:
        seen.append(frame)
        source.close()
    source.close()
    assert 1 <= len(seen) <= 6


def test_a_recording_keeps_depth_sigma_and_amplitude(recording):
    for written, read in zip(frames(), Recording(recording), strict=True):
        for plane in ("depth", "sigma", "amplitude"):
            assert np.allclose(
                getattr(written.image, plane), getattr(read.image, plane), rtol=1e-6, equal_nan=True
            )
        assert read.image.camera == CAMERA


def test_a_torn_recording_ends_at_the_tear(recording):
    whole = recording.read_bytes()
    for part in (0.3, 0.6, 0.95):
        recording.write_bytes(whole[: int(part * len(whole))])
        read = list(Recording(recording))
        assert len(read) == int(part * 6)


def test_a_repeated_recording_goes_on_in_time(recording):
    read = [f for _, f in zip(range(14), Recording(recording, repeat=True), strict=False)]
    assert [f.number for f in read] == list(range(14))
    assert np.allclose(np.diff([f.time_s for f in read]), 1 / 30, atol=1e-6)


@pytest.mark.parametrize("kind", ["mcap", "dir"])
def test_addresses_open_files(kind, recording, folder):
    address = f"{kind}:{recording if kind == 'mcap' else folder}"
    with sources.open_source(address, speed=None) as opened:
        assert len(list(opened)) == 6
    assert opened.name == address


def test_the_synthetic_camera_is_the_same_for_the_same_seed_and_knows_the_truth():
    def first(seed):
        camera = sources.SyntheticCamera("sr3000", seed=seed)
        return [f for _, f in zip(range(3), camera, strict=False)]

    one, same, other = first(0), first(0), first(1)
    for a, b, c in zip(one, same, other, strict=True):
        assert np.array_equal(a.image.depth, b.image.depth, equal_nan=True)
        assert not np.array_equal(a.image.depth, c.image.depth, equal_nan=True)
        assert [s.person for s in a.truth] == [0]


def test_the_second_round_shows_the_same_view_with_other_noise():
    walk = sources.Walk(3, 0.0, 0.2, (0, 0, 450), (-99, 0, 450), (99, 0, 450), stride_s=0.1)
    camera = sources.SyntheticCamera("sr3000", [walk], rate_hz=20.0)
    seen = [f for _, f in zip(range(8), camera, strict=False)]
    first, again = seen[1].image.depth, seen[5].image.depth
    assert seen[5].number == 5
    assert not np.array_equal(first, again, equal_nan=True)
    assert abs(np.nanmedian(first - again)) < 3.0


def test_truth_lies_on_the_surface_that_is_seen():
    camera = sources.SyntheticCamera("sr3000", keep=False)
    for frame in camera:
        if frame.time_s > 1.6:
            break
    tip = frame.truth[0].pose.translation
    u, v = np.rint(frame.image.camera.project(tip)).astype(int)
    near = frame.image.depth[v - 1 : v + 2, u - 1 : u + 2]
    assert abs(np.nanmedian(near) - tip[2]) < 15.0
