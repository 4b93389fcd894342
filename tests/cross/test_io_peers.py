"""Files that other libraries write, and files of ours that they read."""

from io import BytesIO

import cv2
import numpy as np
import pytest
import scan_files as files

from rangeface import Pinhole, RangeImage, io
from rangeface.io import png16, tiff
from rangeface.io._source import Source


@pytest.fixture(params=range(3))
def pixels(request):
    rng = np.random.default_rng(request.param)
    smooth = np.rint(files.depth() * 10).astype(np.uint16)
    large = np.kron(smooth, np.ones((8, 9), np.uint16))
    noisy = np.where(large > 0, large + rng.integers(0, 40, large.shape), 0).astype(np.uint16)
    return (smooth, noisy, rng.integers(0, 65535, (61, 47)).astype(np.uint16))[request.param]


@pytest.mark.parametrize("strategy", [cv2.IMWRITE_PNG_STRATEGY_DEFAULT,
                                      cv2.IMWRITE_PNG_STRATEGY_FILTERED])  # fmt: skip
def test_opencvs_png(pixels, strategy, tmp_path):
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), pixels, [cv2.IMWRITE_PNG_STRATEGY, strategy])
    assert np.array_equal(png16.pixels(Source.open(path)), pixels)


def test_opencv_reads_our_png(pixels, tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(png16.encode(pixels))
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), pixels)


@pytest.mark.parametrize("packing", [1, 5, 8, 32773])
def test_opencvs_tiff(pixels, packing, tmp_path):
    path = tmp_path / "a.tif"
    cv2.imwrite(str(path), pixels, [cv2.IMWRITE_TIFF_COMPRESSION, packing])
    assert np.array_equal(tiff.pixels(Source.open(path)), pixels)


def test_opencvs_float_tiff(pixels, tmp_path):
    path = tmp_path / "a.tif"
    cv2.imwrite(str(path), pixels.astype(np.float32))
    assert np.array_equal(tiff.pixels(Source.open(path)), pixels)


@pytest.mark.parametrize("options", [
    {"compression": "lzw", "predictor": 2}, {"compression": "deflate", "predictor": 3},
    {"tile": (32, 32), "compression": "deflate"}, {"tile": (16, 48)},
    {"byteorder": ">", "compression": "lzw"},
])  # fmt: skip
def test_tifffiles_tiff(pixels, options, tmp_path):
    tifffile = pytest.importorskip("tifffile")
    if "lzw" in options.values():
        pytest.importorskip("imagecodecs")
    image = pixels.astype(np.float32) if options.get("predictor") == 3 else pixels
    tifffile.imwrite(tmp_path / "a.tif", image, **options)
    assert np.array_equal(tiff.pixels(Source.open(tmp_path / "a.tif")), image)


@pytest.mark.parametrize("writer", [files.ply_ascii, files.obj, files.off, files.stl_binary,
                                    files.stl_ascii], ids=lambda f: f.__name__)  # fmt: skip
def test_trimesh_reads_the_same_points(writer, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    path = files.write(writer(), tmp_path)
    theirs = trimesh.load(path, process=False)
    ours = io.read_points(path)
    a = np.unique(np.round(theirs.vertices * [1, -1, -1], 2), axis=0)
    b = np.unique(np.round(ours.points.astype(float), 2), axis=0)
    assert a.shape == b.shape
    assert np.abs(a - b).max() < 0.02
    assert len(theirs.faces) == len(ours.triangles)


def test_trimesh_reads_our_ply(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    cloud = io.read_points(files.write(files.gavab(), tmp_path))
    io.write_points(tmp_path / "a.ply", cloud)
    theirs = trimesh.load(tmp_path / "a.ply", process=False)
    assert np.array_equal(theirs.vertices.astype(np.float32), cloud.points * [1, -1, -1])
    assert np.array_equal(theirs.faces, cloud.triangles)


def test_numpy_reads_our_npz(tmp_path):
    image = RangeImage(np.where(files.depth() > 0, files.depth(), np.nan), files.CAMERA)
    io.write_scan(tmp_path / "a.npz", image)
    with np.load(tmp_path / "a.npz") as arrays:
        assert np.array_equal(arrays["depth"], image.depth, equal_nan=True)


def test_the_mcap_library_reads_our_recording(tmp_path):
    reader = pytest.importorskip("mcap.reader")
    image = RangeImage(np.full((3, 4), 700.0), Pinhole(5, 5, 1.5, 1, 4, 3))
    io.write_frames(tmp_path / "a.mcap", [image] * 2, rate_hz=10)
    with (tmp_path / "a.mcap").open("rb") as stream:
        found = [(s.name, c.topic, m.log_time) for s, c, m in
                 reader.make_reader(stream).iter_messages()]  # fmt: skip
    assert found[1] == ("sensor_msgs/msg/Image", "/depth/image_raw", 0)
    assert found[3][2] == 100_000_000


def test_we_read_the_mcap_librarys_recording(tmp_path):
    writer = pytest.importorskip("mcap.writer")
    pytest.importorskip("zstandard")
    from rangeface.io import mcap
    from rangeface.io._mcap_writer import encode

    plain = encode([RangeImage(np.full((3, 4), 700.0), Pinhole(5, 5, 1.5, 1, 4, 3))] * 3)
    source = Source(tmp_path / "plain", plain)
    with (tmp_path / "z.mcap").open("wb") as stream:  # chunks in zstd, as is its default
        out = writer.Writer(stream)
        out.start()
        channels = {}
        for channel, _, message in mcap._messages(source, BytesIO(plain)):
            if channel.topic not in channels:
                schema = out.register_schema(f"sensor_msgs/msg/{channel.kind}", "ros2msg", b"")
                channels[channel.topic] = out.register_channel(channel.topic, "cdr", schema)
            out.add_message(channels[channel.topic], 0, bytes(message), 0)
        out.finish()
    frames = list(io.read_frames(tmp_path / "z.mcap"))
    assert len(frames) == 3
    assert np.allclose(frames[1].depth, 700)
