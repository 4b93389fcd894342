"""What holds for every file, every cloud and every number."""

import numpy as np
import pytest
import scan_files as files
from hypothesis import given, settings
from hypothesis import strategies as st

from rangeface import Pinhole, RangeImage, io
from rangeface.errors import ParameterError
from rangeface.io._describe import estimate_noise
from rangeface.numerics.polygons import fan, fan_closed, grid_triangles
from rangeface.numerics.splat import splat
from rangeface.numerics.text import numbers
from rangeface.types import Orthographic, PointSet

NUMBER = st.floats(allow_nan=False, allow_infinity=False, width=64)


@settings(deadline=None, max_examples=200)
@given(st.lists(NUMBER, max_size=20), st.sampled_from(["{!r}", "{:.12e}", "{:g}", "{:.3f}"]))
def test_the_scanner_reads_what_python_writes(values, form):
    words = [form.format(v) for v in values]
    text = np.frombuffer(" \n\t".join(words).encode() or b" ", np.uint8)
    found, _ = numbers(text, 0, 100)
    expected = np.array([float(w) for w in words])
    assert len(found) == len(values)
    assert np.allclose(found, expected, rtol=1e-14, atol=1e-300)


@settings(deadline=None, max_examples=200)
@given(st.binary(max_size=200))
def test_the_scanner_stops_inside_the_text(data):
    text = np.frombuffer(data or b"\0", np.uint8)
    found, stop = numbers(text, 0, 50, commas=True)
    assert 0 <= stop <= len(text)
    assert len(found) <= 50


@pytest.mark.parametrize("seed", range(6))
def test_a_polygon_of_n_corners_makes_n_minus_two_triangles(seed):
    rng = np.random.default_rng(seed)
    sizes = rng.integers(0, 9, 30)
    indices = rng.integers(0, 1000, sizes.sum())
    triangles = fan(indices, sizes)
    assert len(triangles) == np.maximum(sizes - 2, 0).sum()
    closed = np.concatenate([np.append(p, -1) for p in np.split(indices, np.cumsum(sizes)[:-1])])
    assert np.array_equal(fan_closed(closed), triangles)


def test_a_grid_is_joined_except_across_a_jump_and_a_hole():
    points = np.stack(np.meshgrid(np.arange(5.0), np.arange(4.0)), -1)
    points = np.concatenate([points, np.zeros((4, 5, 1))], -1).astype(np.float32)
    assert len(grid_triangles(points, 2.0)) == 2 * 3 * 4
    points[:, 2:, 2] = 100.0  # a jump between two columns
    assert len(grid_triangles(points, 2.0)) == 2 * 3 * 3
    points[0, 0] = np.nan  # belongs to one triangle
    assert len(grid_triangles(points, 2.0)) == 2 * 3 * 3 - 1


def test_a_dense_plane_is_splatted_exactly():
    rng = np.random.default_rng(3)
    uv = rng.uniform(0, 40, (20_000, 2))
    depth = splat(uv, np.full(len(uv), 300.0), shape=(40, 40), radius_px=1.0)
    assert np.isfinite(depth[1:-1, 1:-1]).all()
    assert np.nanmax(np.abs(depth - 300)) < 1e-3


def test_the_nearest_surface_hides_the_one_behind():
    grid = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0)), -1).reshape(-1, 2)
    both = np.concatenate([grid, grid])
    z = np.r_[np.full(400, 500.0), np.full(400, 400.0)]
    assert (splat(both, z, shape=(20, 20), radius_px=0.7) == 400).all()


@pytest.mark.parametrize(("radius", "thickness"), [(0.0, 1.0), (np.nan, 1.0), (1.0, -1.0)])
def test_splat_parameters(radius, thickness):
    with pytest.raises(ParameterError, match=r"radius_px|thickness_mm"):
        splat([[0, 0]], [1], shape=(1, 1), radius_px=radius, thickness_mm=thickness)


@pytest.mark.parametrize("writer", [files.obj, files.xyz])
def test_far_outliers_and_islands_do_not_set_the_view(writer, tmp_path):
    plain = io.read_scan(files.write(writer(), tmp_path))
    head = "v " if writer is files.obj else ""
    rng = np.random.default_rng(5)
    far = rng.normal(0, 1, (40, 3))
    far = far / np.linalg.norm(far, axis=1, keepdims=True) * rng.uniform(400, 90_000, (40, 1))
    island = [[300 + x, 300 + y, -700] for x in range(5) for y in range(5)]
    rows = [head + " ".join(f"{c:.3f}" for c in p) for p in [*far - [0, 0, 700], *island]]
    name, data = next(iter(writer().items()))
    text = data.decode()
    if writer is files.obj:  # in front of the faces with negative indices they would renumber
        text = text.replace("\nvt ", "\n" + "\n".join(rows) + "\nvt ")
        n = len(rows)
        text = "\n".join(_shift(line, n) for line in text.split("\n"))
    else:
        text += "\n".join(rows) + "\n"
    (tmp_path / name).write_text(text)
    messy = io.read_scan(tmp_path / name)
    assert messy.shape == plain.shape
    assert np.allclose(messy.depth, plain.depth, atol=1e-3, equal_nan=True)


def _shift(line, n):
    if not line.startswith("f -"):
        return line
    return "f " + " ".join(f"{int(w.split('/')[0]) - n}//-1" for w in line.split()[1:])


@pytest.mark.parametrize("turn", [("+z", "+y"), ("-y", "+z"), ("+x", "+y"), ("-z", "-y")])
def test_the_view_is_the_same_from_whichever_axis_the_file_calls_front(turn, tmp_path):
    from rangeface.io._cloud import view_rotation

    base = files.points_and_triangles(files.face())[0]
    camera = base @ view_rotation("+z", "+y").T
    stored = camera @ view_rotation(*turn)  # the inverse of what reading applies
    path = tmp_path / "a.xyz"
    np.savetxt(path, stored, fmt="%.5f")
    points = io.read_points(path, front=turn[0], up=turn[1]).points
    assert np.abs(points - camera).max() < 1e-3


def test_a_pinhole_can_be_the_virtual_camera(tmp_path):
    path = files.write(files.gavab(), tmp_path)
    camera = Pinhole(500, 500, 60, 60, 121, 121)
    image = io.read_scan(path, camera=camera)
    assert image.camera == camera
    assert abs(image.depth[60, 60] - np.nanmin(image.depth)) < 2.0


@pytest.mark.parametrize("suffix", sorted(io.WRITERS))
def test_what_is_written_is_read_back(suffix, tmp_path):
    depth = np.where(files.depth() > 0, files.depth(), np.nan)
    image = RangeImage(depth, files.CAMERA, sigma=np.full(depth.shape, 1.5))
    path = tmp_path / f"a{suffix}"
    io.write_scan(path, image)
    if suffix == ".ply":
        points = io.read_points(path).points
        assert np.abs(points - image.points[image.mask]).max() < 0.01
    else:
        back = io.read_scan(path)
        assert back.camera == image.camera
        assert np.nanmax(np.abs(back.depth - image.depth)) <= 0.0101
        assert np.array_equal(back.mask, image.mask)
    if suffix == ".npz":
        assert np.array_equal(back.sigma, image.sigma)
    assert not list(tmp_path.glob(".*"))


def test_an_orthographic_image_keeps_depth_below_zero(tmp_path):
    image = RangeImage([[5.0, -5.0], [np.nan, 0.0]], Orthographic(2.0, 0.5, 0.5, 2, 2))
    io.write_scan(tmp_path / "a.npz", image)
    back = io.read_scan(tmp_path / "a.npz")
    assert np.array_equal(back.depth, image.depth, equal_nan=True)
    assert back.camera == image.camera


def test_points_are_written_with_their_triangles(tmp_path):
    cloud = PointSet([[0, 0, 5], [9, 0, 5], [0, 9, 5]], [[0, 1, 2]])
    io.write_points(tmp_path / "a.ply", cloud)
    back = io.read_points(tmp_path / "a.ply")
    assert np.array_equal(back.points, cloud.points)
    assert np.array_equal(back.triangles, cloud.triangles)


@pytest.mark.parametrize("writer", files.FILES.values(), ids=lambda f: f.__name__)
def test_reading_is_deterministic_and_leaves_the_file_alone(writer, tmp_path):
    path = files.write(writer(), tmp_path)
    before = path.read_bytes()
    first, second = io.read_scan(path), io.read_scan(path)
    assert np.array_equal(first.depth, second.depth, equal_nan=True)
    assert first.camera == second.camera
    assert path.read_bytes() == before


@pytest.mark.parametrize("sigma", [0.5, 2.0, 6.0])
def test_the_noise_estimate_is_the_noise_of_a_curved_surface(sigma):
    v, u = np.mgrid[:80, :60].astype(float)
    rng = np.random.default_rng(2)
    depth = 700 + 0.02 * (u - 30) ** 2 + 0.01 * (v - 40) ** 2 + rng.normal(0, sigma, u.shape)
    depth[rng.random(depth.shape) < 0.05] = np.nan
    assert estimate_noise(depth.astype(np.float32)) == pytest.approx(sigma, rel=0.08)


def test_a_description_is_ready_to_print(tmp_path):
    found = io.describe_scan(files.write(files.rap3df(), tmp_path))
    words = dict(found.lines())
    assert found.format == "rap3df"
    assert "119 × 149 px" in words["image"]
    assert words["unit"] == "mm"
    assert "amplitude" in words["planes"]
    assert found.near_mm < found.far_mm
    cloud = dict(io.describe_scan(files.write(files.pcd_binary(), tmp_path)).lines())
    assert cloud["unit"] == "m"


def test_a_face_in_two_parts_stays_whole(tmp_path):
    grid = files.face(60, 52, 2.0)
    grid[22:30] = np.nan  # a band of 16 mm without a point
    upper, lower = np.add(grid[:22], [0, 35, 0]), grid[30:]  # and 35 mm more
    points = np.concatenate([p[np.isfinite(p[..., 2])] for p in (upper, lower)])
    np.savetxt(tmp_path / "a.xyz", points)
    image = io.read_scan(tmp_path / "a.xyz")
    assert image.shape[0] * 1.5 > np.ptp(points[:, 1])


@pytest.mark.parametrize("name", ["gavab", "png", "recording", "bnt"])
@pytest.mark.parametrize("suffix", sorted(io.WRITERS))
def test_conversion_keeps_the_surface(name, suffix, tmp_path):
    path = files.write(files.FILES[name](), tmp_path)
    target = tmp_path / f"converted{suffix}"
    flat = name in ("gavab", "bnt")
    if suffix == ".mcap" and flat:
        with pytest.raises(ParameterError, match="pinhole"):
            io.convert_scan(path, target)
        return
    io.convert_scan(path, target)
    if suffix == ".ply":
        points = io.read_points(path).points
        assert np.abs(io.read_points(target).points - points).max() < 1e-3
        return
    back, image = io.read_scan(target), io.read_scan(path)
    assert np.nanmax(np.abs(back.depth - image.depth)) < 0.011
    if name == "recording" and suffix == ".mcap":
        assert len(list(io.read_frames(target))) == 3
