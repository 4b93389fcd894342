"""Databases in their own layouts: who, which take, and which protocol uses it how."""

import numpy as np
import pytest
import scan_files as files

from rangeface import datasets
from rangeface.errors import ScanError


def fill(root, names, content):
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(content)


def roles(scans):
    return {(s.subject, s.session): s.role for s in scans}


def test_gavab_and_its_two_protocols(tmp_path):
    takes = [
        "frontal1",
        "frontal2",
        "arriba",
        "abajo",
        "derecha",
        "izquierda",
        "gesto",
        "risa",
        "sonrisa",
    ]
    names = [f"cara{n}/cara{n}_{take}.wrl" for n in (1, 2, 61) for take in takes]
    fill(tmp_path, names[:-1], files.gavab(files.face(12, 10, 9.0))["cara1_frontal1.wrl"])
    scans = datasets.gavab(tmp_path)
    assert len(scans) == 26
    assert scans[0].load().mask.any()
    facts = {s.session: (s.view, s.expression) for s in scans}
    assert facts["arriba"] == ("up", "neutral")
    assert facts["risa"] == ("frontal", "laugh")
    database = datasets.DATABASES["gavab"]
    paper = roles(database.protocols["paper"](scans))
    assert len(paper) == 11
    assert paper["cara1", "sonrisa"] == paper["cara1", "frontal1"] == "gallery"
    assert paper["cara1", "risa"] == paper["cara1", "frontal2"] == "probe"
    common = database.protocols["common"](scans)
    assert [s.session for s in common if s.role == "gallery"] == ["frontal1"] * 3
    assert sum(s.role == "probe" for s in common) == 23
    missing = database.missing(scans)
    assert "cara61: sonrisa" in missing
    assert "cara3: all" in missing
    assert len(missing) == 59


def test_bosphorus_with_landmarks(tmp_path):
    names = ["bs000_N_N_1.bnt", "bs000_N_N_0.bnt", "bs000_E_HAPPY_0.bnt", "bs000_YR_R20_0.bnt",
             "bs000_O_EYE_0.bnt", "bs001_LFAU_12R_0.bnt"]  # fmt: skip
    fill(tmp_path, names, files.bnt(files.face(12, 10, 9.0))["bs000_N_N_0.bnt"])
    (tmp_path / "bs000_N_N_0.lm3").write_text("1 landmarks:\nNose tip\n1 2 3\n")
    scans = datasets.bosphorus(tmp_path)
    first = next(s for s in scans if s.session == "N_N_0")
    assert first.landmarks["nose_tip"].tolist() == [1, -2, -3]
    assert {s.session: s.view for s in scans}["YR_R20_0"] == "YR_R20"
    assert {s.session: s.expression for s in scans}["E_HAPPY_0"] == "HAPPY"
    used = datasets.DATABASES["bosphorus"].protocols["first-neutral"](scans)
    assert roles(used)["bs000", "N_N_0"] == "gallery"
    assert sum(s.role == "probe" for s in used) == 4
    assert "bs001: no neutral scan" in datasets.DATABASES["bosphorus"].missing(scans)


def test_frgc_orders_by_number_and_divides_by_season(tmp_path):
    text = files.abs_text(files.face(12, 10, 9.0))["02463d452.abs"]
    names = ["Spring2003range/02463d100.abs", "Fall2003range/02463d452.abs",
             "Spring2004range/02463d1000.abs", "Fall2003range/04200d74.abs"]  # fmt: skip
    fill(tmp_path, names, text)
    scans = datasets.frgc(tmp_path)
    assert [s.path.stem for s in scans] == ["02463d100", "02463d452", "02463d1000", "04200d74"]
    protocols = datasets.DATABASES["frgc"].protocols
    assert [s.role for s in protocols["first-scan"](scans)] == [
        "train", "gallery", "probe", "gallery",
    ]  # fmt: skip
    assert [s.role for s in protocols["later-sessions"](scans)] == [
        "train", "gallery", "probe", "gallery",
    ]  # fmt: skip
    assert "2 of 466 people of the validation partition" in datasets.DATABASES["frgc"].missing(
        scans
    )


def test_lock3dface_takes_a_frame_of_each_video(tmp_path):
    from rangeface.io.png16 import encode

    image = np.full((424, 512), 800, np.uint16)
    for video in ("001_Kinect_NU_2DEPTH", "001_Kinect_NU_1DEPTH", "001_Kinect_PS_1DEPTH"):
        fill(tmp_path, [f"{video}/01.png", f"{video}/02.png"], encode(image))
    scans = datasets.lock3dface(tmp_path, frame=1)
    assert scans[0].load().camera.fx == 365.5
    used = datasets.DATABASES["lock3dface"].protocols["first-neutral"](scans)
    assert roles(used) == {("001", "NU_1"): "gallery", ("001", "NU_2"): "probe",
                           ("001", "PS_1"): "probe"}  # fmt: skip
    (tmp_path / "001_Kinect_FE_1DEPTH").mkdir()
    empty = next(s for s in datasets.lock3dface(tmp_path) if s.session == "FE_1")
    with pytest.raises(ScanError, match="no PNG"):
        empty.load()


def test_biwi_frames_have_poses_and_the_most_frontal_is_enrolled(tmp_path):
    whole = files.biwi()
    fill(tmp_path, ["01/frame_00003_depth.bin", "01/frame_00004_depth.bin"],
         whole["frame_00003_depth.bin"])  # fmt: skip
    (tmp_path / "01/depth.cal").write_bytes(whole["depth.cal"])
    (tmp_path / "01/frame_00003_pose.txt").write_text("0 0 1\n0 1 0\n-1 0 0\n\n1 2 900\n")
    np.array([1, 2, 900, 0, 5, 0], "<f4").tofile(tmp_path / "01/frame_00004_pose.bin")
    scans = datasets.biwi(tmp_path)
    assert [s.view for s in scans] == ["90 0 0", "5 0 0"]
    assert scans[0].landmarks["head"].tolist() == [1, 2, 900]
    used = datasets.DATABASES["biwi"].protocols["frontal-gallery"](scans)
    assert [s.role for s in used] == ["probe", "gallery"]
    assert used[1].load().camera.fx == files.CAMERA.fx


@pytest.mark.parametrize("name", datasets.DATABASES)
def test_every_database_says_what_it_looks_for(name, tmp_path):
    database = datasets.DATABASES[name]
    with pytest.raises(ScanError):
        database.index(tmp_path)
    assert database.layout
    assert database.protocols
