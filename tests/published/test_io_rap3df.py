"""RAP3DF: the arithmetic of its bytes, and the real captures where they are at hand."""

import os
from pathlib import Path

import numpy as np
import pytest

from rangeface import datasets, io
from rangeface.io import rap3df

DATA = Path(os.environ.get("RANGEFACE_DATA", Path(__file__).parents[2] / "../shared/data"))


def write(path, depth_byte, ir_byte=None):
    depth_byte.astype("<u2").tofile(path)
    if ir_byte is not None:
        name = path.name.replace("depth.data", "ir.data")
        ir_byte.astype("<u2").tofile(path.with_name(name))


def test_a_byte_is_a_bin_of_four_or_eight_millimetres(tmp_path):
    byte = np.zeros((rap3df.HEIGHT, rap3df.WIDTH), int)
    byte[0, :4] = 1, 127, 128, 255
    path = tmp_path / "k1_box_xyz_depth.data"
    write(path, byte)
    image = io.read_scan(path)
    assert image.depth[0, :4].tolist() == [518.0, 1022.0, 1028.0, 2044.0]
    assert image.mask.sum() == 4
    assert image.sigma[0, 0] == pytest.approx(np.hypot(4 / 12**0.5, 1.5), rel=1e-6)
    assert image.sigma[0, 3] == pytest.approx(np.hypot(8 / 12**0.5, 1.5), rel=1e-6)
    assert image.amplitude is None


def test_amplitude_comes_back_up_to_one_factor(tmp_path):
    v, u = np.mgrid[: rap3df.HEIGHT, : rap3df.WIDTH]
    amplitude = 300.0 * np.exp(1.5 * np.sin(u / 20.0) + np.cos(v / 25.0))
    byte = (amplitude.astype("<f4").view("<u4") >> 16) & 255
    path = tmp_path / "k1_box_xyz_depth.data"
    write(path, np.full(byte.shape, 70), byte)
    ratio = io.read_scan(path).amplitude / amplitude
    assert ratio.std() / ratio.mean() < 0.004  # a bin of the mantissa is 1/128


def test_amplitude_from_the_bitmap_of_a_test_capture(tmp_path):
    h, w = rap3df.HEIGHT, rap3df.WIDTH
    red = np.zeros((h, w), np.uint8)
    red[:, :] = np.linspace(10, 120, h)[:, None]
    rows = np.zeros((h, 360), np.uint8)
    rows[::-1, 2 : 3 * w : 3] = red  # blue, green, red; the bottom row comes first
    head = b"BM" + np.array([54 + rows.size, 0, 54, 40, w, h], "<u4").tobytes()
    head += np.array([1, 24], "<u2").tobytes() + bytes(24)
    (tmp_path / "ABCk1_box_xy_ir_view.bmp").write_bytes(head + rows.tobytes())
    path = tmp_path / "ABCk1_box_xyz_depth.data"
    write(path, np.full((h, w), 70))
    amplitude = io.read_scan(path).amplitude
    assert amplitude[-1, 0] / amplitude[0, 0] == pytest.approx(
        (1 + 120.5 / 128) / (1 + 10.5 / 128), rel=1e-3
    )


def test_the_original_folder_has_267_captures_of_62_people():
    if not (DATA / "rap3df_2017").is_dir():
        pytest.skip(f"no data at {DATA}")
    scans = datasets.rap3df(DATA / "rap3df_2017")
    rows = (DATA / "rap3df_2017_reference.csv").read_text().splitlines()[1:]
    listed = {tuple(row.split(",")[:3]) for row in rows}
    root = DATA / "rap3df_2017" / "rap3df_data"
    assert {(s.path.relative_to(root).as_posix(), s.subject, s.role) for s in scans} == listed
    images = [s.load() for s in scans[:12]]
    assert all(0.2 < image.mask.mean() < 0.95 for image in images)
    assert all(600 < np.nanmedian(image.depth) < 1200 for image in images)
    assert all(np.isfinite(image.amplitude[image.mask]).all() for image in images)
