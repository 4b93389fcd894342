"""A bad scan file gives one line that names the file and what is wrong."""

import numpy as np
import pytest

from rangeface import Pinhole, datasets, io
from rangeface.errors import ParameterError, ScanError, ScanFault
from rangeface.io.png16 import encode

CAMERA = "width=4\nheight=3\nfx=5\nfy=5\ncx=1.5\ncy=1\n"
DEPTH = np.full((3, 4), 700, np.uint16)


def png(folder, toml=None, depth=DEPTH):
    path = folder / "scan.png"
    path.write_bytes(encode(depth))
    if toml is not None:
        (folder / "scan.toml").write_text(toml)
    return path


def refuse(path, fault, words="", **options):
    with pytest.raises(ScanError) as caught:
        io.read_scan(path, **options)
    assert caught.value.fault is fault
    assert str(path) in str(caught.value) or ".toml" in str(caught.value)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_and_unreadable(tmp_path):
    refuse(tmp_path / "nothing.png", ScanFault.MISSING)
    refuse(tmp_path, ScanFault.UNREADABLE)
    refuse(str(tmp_path / "a\0b"), ScanFault.UNREADABLE)
    (tmp_path / "empty").touch()
    refuse(tmp_path / "empty", ScanFault.TRUNCATED)
    (tmp_path / "prose").write_text("a story of no scan")
    refuse(tmp_path / "prose", ScanFault.UNKNOWN_FORMAT)


@pytest.mark.parametrize(
    ("toml", "fault", "words"),
    [
        (None, ScanFault.BAD_CAMERA, "camera.toml"),
        (CAMERA, ScanFault.UNKNOWN_UNIT, "nothing is guessed"),
        (CAMERA + 'depth_unit="furlong"', ScanFault.UNKNOWN_UNIT, "furlong"),
        (CAMERA + "depth_scale_mm=0", ScanFault.UNKNOWN_UNIT, "depth_scale_mm"),
        (CAMERA + "depth_scale_mm=1\ndepth_unit='mm'", ScanFault.UNKNOWN_UNIT, "both"),
        (CAMERA + "skew=1", ScanFault.BAD_CAMERA, "skew"),
        (CAMERA.replace("fx=5", "fx=nan"), ScanFault.BAD_CAMERA, "fx"),
        (CAMERA.replace("cy=1", "cy=inf"), ScanFault.BAD_CAMERA, "cy"),
        (CAMERA.replace("fy=5", "fy=0"), ScanFault.BAD_CAMERA, "fy"),
        (CAMERA.replace("fy=5", "fy='5'"), ScanFault.BAD_CAMERA, "fy"),
        (CAMERA.replace("fx=5", ""), ScanFault.BAD_CAMERA, "fx"),
        (CAMERA.replace("width=4", "width=inf"), ScanFault.BAD_CAMERA, "width"),
        (CAMERA.replace("width=4", "width=6") + "depth_unit='mm'", ScanFault.WRONG_SIZE, "6 × 3"),
        (CAMERA.replace("width=4", "width=" + "9" * 30), ScanFault.BAD_CAMERA, "width"),
        (CAMERA.replace("fx=5", "fx=" + "9" * 400), ScanFault.BAD_CAMERA, "fx"),
        ("width = ", ScanFault.MALFORMED, "TOML"),
    ],
)
def test_camera_files(tmp_path, toml, fault, words):
    refuse(png(tmp_path, toml), fault, words)


def test_all_pixels_invalid(tmp_path):
    path = png(tmp_path, CAMERA + "depth_unit='mm'", np.zeros((3, 4), np.uint16))
    refuse(path, ScanFault.NO_VALID_PIXELS)


def test_a_unit_of_the_caller_goes_first_and_must_be_known(tmp_path):
    path = png(tmp_path, CAMERA + "depth_unit='mm'")
    assert io.read_scan(path, unit="0.1mm").depth[0, 0] == 70.0
    refuse(path, ScanFault.UNKNOWN_UNIT, "league", unit="league")


def test_a_camera_of_the_caller_must_fit(tmp_path):
    path = png(tmp_path)
    image = io.read_scan(path, camera=Pinhole(5, 5, 1, 1, 4, 3), unit="mm")
    assert image.depth[1, 1] == 700.0
    refuse(path, ScanFault.WRONG_SIZE, camera=Pinhole(5, 5, 1, 1, 3, 3), unit="mm")


def test_parameters():
    with pytest.raises(ParameterError, match="pitch_mm"):
        io.read_scan("any", pitch_mm=0.0)
    with pytest.raises(ParameterError, match="max_bytes"):
        io.Limits(max_bytes=0)


def test_points_in_another_unit_are_asked_about(tmp_path):
    path = tmp_path / "metres.obj"
    path.write_text("".join(f"v {x / 1000} {y / 1000} 0\n" for x in range(90) for y in range(90)))
    refuse(path, ScanFault.UNKNOWN_UNIT, "unit='m'")
    assert io.read_scan(path, unit="m").mask.mean() > 0.8
    with pytest.raises(ParameterError, match="front"):
        io.read_scan(path, unit="m", front="forward")
    with pytest.raises(ParameterError, match="line"):
        io.read_scan(path, unit="m", front="+z", up="-z")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "path,subject"),
        ("path,subject\na,b\n", "role"),
        ("path,subject,role,colour\na,b,probe,red\n", "colour"),
        ("path,subject,role\na,,probe\n", "line 2"),
        ("path,subject,role\na,b,guest\n", "guest"),
        ("path,subject,role\na,b\n", "2 cells"),
        ("path,subject,role\n", "nothing here"),
    ],
)
def test_a_bad_index_is_refused(tmp_path, text, words):
    if text is not None:
        (tmp_path / "index.csv").write_text(text)
    with pytest.raises(ScanError, match=words):
        datasets.folder(tmp_path)


def test_folders_without_a_database(tmp_path):
    with pytest.raises(ScanError, match="no such folder"):
        datasets.rap3df(tmp_path / "none")
    with pytest.raises(ScanError, match="k1_box_xyz_depth"):
        datasets.rap3df(tmp_path)


def test_a_users_folder_is_read_and_a_broken_file_fails_alone(tmp_path):
    (tmp_path / "anna").mkdir()
    png(tmp_path / "anna")
    (tmp_path / "camera.toml").write_text(CAMERA + "depth_unit='mm'")
    (tmp_path / "index.csv").write_text(
        "path,subject,role,view,session\r\nanna/scan.png,anna,gallery,frontal,1\r\n"
        "anna/gone.png,anna,probe,left,2\r\n"
    )
    first, second = datasets.folder(tmp_path)
    assert (first.subject, first.role, first.view, first.session) == (
        "anna", "gallery", "frontal", "1",
    )  # fmt: skip
    assert first.load().depth[0, 0] == 700.0
    with pytest.raises(ScanError, match=r"gone\.png"):
        second.load()


def test_points_in_micrometres_are_asked_about(tmp_path):
    path = tmp_path / "a.xyz"
    path.write_text("".join(f"{x} {y} 0\n" for x in range(0, 90_000, 900) for y in range(90)))
    refuse(path, ScanFault.UNKNOWN_UNIT, "unit='um'")


def test_a_conversion_to_an_unknown_format(tmp_path):
    with pytest.raises(ParameterError, match="gif"):
        io.convert_scan(tmp_path / "a.ply", tmp_path / "a.gif")
    with pytest.raises(ScanError, match=r"none\.ply"):
        io.convert_scan(tmp_path / "none.ply", tmp_path / "a.npz")
