"""Every format, in its exact layout and with its quirks, comes back to 0.01 mm."""

import numpy as np
import pytest
import scan_files as files

from rangeface import Pinhole, io
from rangeface.io._formats import identify
from rangeface.io._source import Source

FORMAT = {
    "gavab": "vrml", "vrml2": "vrml", "ply_ascii": "ply", "ply_binary": "ply", "ply_big": "ply",
    "ply_grid": "ply", "stl_binary": "stl", "stl_ascii": "stl", "pcd_ascii": "pcd",
    "pcd_binary": "pcd", "pcd_compressed": "pcd", "csv": "xyz", "bnt": "bosphorus",
    "abs_text": "frgc", "truedepth": "png", "tiff_lzw_file": "tiff", "tiff_deflate": "tiff",
    "recording": "mcap", "recording_chunked": "mcap",
}  # fmt: skip


def camera_axes(grid):
    return grid[np.isfinite(grid[..., 2])] * [1, -1, -1]


def same_points(a, b, tolerance=0.01):
    a, b = (p[np.lexsort(np.round(p, 1).T)] for p in (np.asarray(a, float), np.asarray(b, float)))
    return a.shape == b.shape and np.abs(a - b).max() < tolerance


@pytest.mark.parametrize("name", files.FILES)
def test_a_format_is_known_by_its_content(name, tmp_path):
    if name == "abs_gz":
        pytest.skip("gzip is opened before")
    path = files.write(files.FILES[name](), tmp_path)
    blind = path.with_name("scan")
    blind.write_bytes(path.read_bytes())
    assert identify(Source.open(blind)) == FORMAT.get(name, name)


@pytest.mark.parametrize("writer", files.CLOUDS, ids=lambda f: f.__name__)
def test_clouds_and_meshes(writer, tmp_path):
    path = files.write(writer(), tmp_path)
    cloud = io.read_points(path)
    assert same_points(cloud.points, camera_axes(files.face()))
    image = io.read_scan(path)
    expected = camera_axes(files.face())
    nose = expected[expected[:, 2].argmin()]
    u, v = np.rint(image.camera.project(nose)).astype(int)
    assert abs(image.depth[v, u] - nose[2]) < 1.0
    area = len(expected) * 16.0 / 1.5**2  # pixels that the face covers
    assert 0.75 * area < image.mask.sum() < 1.15 * area


@pytest.mark.parametrize("writer", [w for w in files.CLOUDS if w not in (files.xyz, files.csv)],
                         ids=lambda f: f.__name__)  # fmt: skip
def test_a_meshs_faces_lie_on_its_surface(writer, tmp_path):
    path = files.write(writer(), tmp_path)
    cloud = io.read_points(path)
    corners = cloud.points[cloud.triangles]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert edges.max() < 16.0  # the mesh's own neighbours, 4 mm apart, on a slope
    n_quads = len(files.points_and_triangles(files.face())[2])
    assert len(cloud.triangles) >= 2 * n_quads


@pytest.mark.parametrize("writer", files.GRIDS, ids=lambda f: f.__name__)
def test_grids(writer, tmp_path):
    path = files.write(writer(), tmp_path)
    cloud = io.read_points(path)
    assert same_points(cloud.points, camera_axes(files.face()))
    assert cloud.triangles is not None
    assert io.read_scan(path).mask.sum() > 3000


@pytest.mark.parametrize("writer", files.DEPTHS, ids=lambda f: f.__name__)
def test_depth_images(writer, tmp_path):
    image = io.read_scan(files.write(writer(), tmp_path))
    expected = np.where(files.depth() > 0, files.depth(), np.nan)
    step = {"png": 0.1, "truedepth": 0.1, "tiff": 0.1, "tiff_lzw_file": 0.1, "biwi": 1.0}
    rounding = step.get(writer.__name__, 0.0)
    if writer is files.biwi:
        expected = np.floor(expected)
        rounding = 0.0
    elif rounding:
        expected = np.rint(expected / rounding) * rounding
    assert np.array_equal(image.mask, np.isfinite(expected))
    assert np.nanmax(np.abs(image.depth - expected)) < 0.01
    for name in ("fx", "fy", "cx", "cy"):
        assert getattr(image.camera, name) == pytest.approx(getattr(files.CAMERA, name), rel=1e-3)


@pytest.mark.parametrize("compression", [1, 5, 8, 32773])
@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("predictor", [1, 2])
def test_tiff_in_every_packing(compression, order, predictor, tmp_path):
    data = files.tiff(compression=compression, order=order, predictor=predictor)
    image = io.read_scan(files.write(data, tmp_path))
    expected = np.rint(np.where(files.depth() > 0, files.depth(), np.nan) * 10) / 10
    assert np.allclose(image.depth, expected, atol=0.01, equal_nan=True)


def test_swissranger_gives_camera_and_amplitude(tmp_path):
    image = io.read_scan(files.write(files.swissranger(), tmp_path))
    assert image.shape == (144, 176)
    assert image.camera.fx == pytest.approx(200, rel=1e-4)
    assert image.camera.cx == pytest.approx(87.5, abs=1e-2)
    assert image.amplitude.max() == pytest.approx(2000, rel=1e-4)
    assert image.depth[72, 88] == pytest.approx(400.0, abs=0.01)


@pytest.mark.parametrize("titles", [
    ("Calibrated Distance",),
    ("calibrated  distance [m]", "Amplitude"),
    ("Calibrated yVector", "Calibrated xVector", "Calibrated Distance"),
    ("Distance Data", "Confidence Map"),
])  # fmt: skip
def test_swissranger_blocks_may_be_missing_and_titles_vary(titles, tmp_path):
    image = io.read_scan(files.write(files.swissranger(titles), tmp_path))
    assert image.depth[72, 88] == pytest.approx(400.0, abs=0.01)
    assert image.camera.fx == pytest.approx(200, rel=1e-4)
    assert (image.amplitude is not None) == ("Amplitude" in titles)


def test_vap_marks_negative_depth_invalid(tmp_path):
    image = io.read_scan(files.write(files.vap(), tmp_path))
    assert image.shape == (480, 640)
    assert not image.mask.ravel()[::7].any()
    assert image.depth[0, 1] == 701.0


def test_a_recording_gives_its_frames_and_survives_a_tear(tmp_path):
    path = files.write(files.recording(), tmp_path)
    frames = list(io.read_frames(path))
    assert len(frames) == 3
    assert np.nanmax(np.abs(frames[2].depth - frames[0].depth - 2)) < 1e-3
    path.write_bytes(path.read_bytes()[:-2000])
    assert len(list(io.read_frames(path))) == 2


@pytest.mark.parametrize("packing", ["zstd", "lz4"])
def test_a_compressed_recording_is_expanded_apart(packing, tmp_path):
    pytest.importorskip({"zstd": "zstandard", "lz4": "lz4.frame"}[packing])
    path = files.write(files.recording_chunked(packing), tmp_path)
    assert len(list(io.read_frames(path))) == 3


def test_truedepth_takes_the_callers_camera(tmp_path):
    path = files.write(files.truedepth(), tmp_path)
    own = Pinhole(500, 500, 12, 14, files.CAMERA.width, files.CAMERA.height)
    assert io.read_scan(path, camera=own, unit="0.1mm").camera == own


def test_landmarks_and_poses(tmp_path):
    path = tmp_path / "bs000_N_N_0.lm3"
    rows = ["# made by a test", "", "2 landmarks:", "Nose tip", "1.5 -2.5 30", "Chin middle"]
    path.write_text("\r\n".join([*rows, "0 -60 10.25", ""]))
    marks = io.read_landmarks(path)
    assert marks["nose_tip"].tolist() == [1.5, 2.5, -30.0]
    assert marks["chin_middle"].tolist() == [0.0, 60.0, -10.25]
    pose = tmp_path / "frame_00003_pose.txt"
    pose.write_text("1 0 0 \n0 0 -1 \n0 1 0 \n\n91.5 -20.25 900 \n")
    found = io.read_pose(pose)
    assert found.translation.tolist() == [91.5, -20.25, 900.0]
    assert found.rotation[2, 1] == 1.0
    other = tmp_path / "frame_00003_pose.bin"
    np.array([1, 2, 800, 0, 30, 0], "<f4").tofile(other)
    assert io.read_pose(other).rotation[0, 2] == pytest.approx(0.5)


def test_gavabs_display_scale_is_passed_over_but_other_transforms_are_not(tmp_path):
    text = files.gavab()["cara1_frontal1.wrl"].replace(b"0.5 0.5 0.5", b"2 2 2")
    path = files.write({"b.wrl": text}, tmp_path)
    assert same_points(io.read_points(path).points, 2 * camera_axes(files.face()), 0.02)


def test_vrml_comments_may_hold_brackets_and_a_mark_may_come_first(tmp_path):
    text = files.vrml2()["F0001_NE00WH_F3D.wrl"].replace(b"# point", b"# [0] {point}")
    path = files.write({"a.wrl": b"\xef\xbb\xbf" + text}, tmp_path)
    assert same_points(io.read_points(path).points, camera_axes(files.face()))


def test_swissranger_titles_may_follow_each_other(tmp_path):
    text = files.swissranger()["sr.dat"]
    text = b"% SwissRanger SR-3000, distance and amplitude\r\n% 2009-05-05\r\n" + text
    image = io.read_scan(files.write({"a.dat": text}, tmp_path))
    assert image.depth[72, 88] == pytest.approx(400.0, abs=0.01)


@pytest.mark.parametrize("name", ["K", "intrinsics", "camera"])
def test_npz_with_a_matrix(name, tmp_path):
    K = np.array([[500.0, 0, 12], [0, 510, 14], [0, 0, 1]])
    np.savez(tmp_path / "a.npz", depth=np.asfortranarray(files.depth()), **{name: K})
    camera = io.read_scan(tmp_path / "a.npz").camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (500, 510, 12, 14)


def test_vrml_1_state_is_saved_by_separators(tmp_path):
    text = """#VRML V1.0 ascii
    DEF S Separator { Translation { translation 1000 0 0 }
      Separator { Coordinate3 { point [ 0 0 0, 90 0 0, 0 90 0 ] }
                  IndexedFaceSet { coordIndex [ 0 1 2 ] } } }
    Separator { Rotation { rotation 0 0 1 3.14159265 }
      Coordinate3 { point [ 0 0 0, 90 0 0, 0 90 0 ] } PointSet { numPoints 3 } }
    Switch { whichChild 0 Separator { Coordinate3 { point [ 7 7 7 ] } PointSet { } }
             Separator { Coordinate3 { point [ 8 8 8 ] } PointSet { } } }
    """
    path = files.write({"a.wrl": text.encode()}, tmp_path)
    cloud = io.read_points(path)
    expected = [[1000, 0, 0], [1090, 0, 0], [1000, -90, 0], [0, 0, 0], [-90, 0, 0], [0, 90, 0],
                [7, -7, -7]]  # fmt: skip
    assert np.allclose(cloud.points, expected, atol=1e-3)
    assert cloud.triangles.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("text", [
    "OFF 3 1 0\n0 0 0\n90 0 0\n0 90 0\n3 0 1 2\n",
    "OFF\n# a comment\n\n3 1 3 # counts\n0 0 0\n\n90 0 0\n0 90 0\n3  0 1 2  0.5 0.5 0.5\n",
    "NOFF\r\n3 1 0\r\n0 0 0 0 0 1\r\n90 0 0 0 0 1\r\n0 90 0 0 0 1\r\n3 0 1 2\r\n",
    "v 0 0 0\rv 90 0 0\rv 0 90 0\rf 1 2 3\r",
    "\n\n# OBJ\n  v 0 0 0 1.0\n\tv 9e1 0. .0\nv 0 +90 0\nf -3 -2 -1 # end",
    "ply\rformat ascii 1.0\relement vertex 3\rproperty double x\rproperty double y\r"
    "property double z\relement face 1\rproperty list int32 uint32 vertex_index\rend_header\r"
    "0 0 0\r90 0 0\r0 90 0\r3 0 1 2\r",
])  # fmt: skip
def test_a_triangle_however_it_is_spelt(text, tmp_path):
    cloud = io.read_points(files.write({"a": text.encode()}, tmp_path))
    assert cloud.points.tolist() == [[0, 0, 0], [90, 0, 0], [0, -90, 0]]
    assert cloud.triangles.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("ros1", [False, True])
def test_a_compressed_depth_image_of_a_recording(ros1, tmp_path):
    pixels = np.rint(files.depth()).astype(np.uint16)
    path = files.write(files.recording_compressed_images(pixels, ros1=ros1), tmp_path)
    image = io.read_scan(path, camera=files.CAMERA)
    assert np.array_equal(np.nan_to_num(image.depth), pixels)
