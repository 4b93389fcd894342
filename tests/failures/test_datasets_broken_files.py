"""What a database's own side files can have wrong."""

import pytest
import scan_files as files

from rangeface import datasets
from rangeface.errors import ScanError


def test_a_broken_landmark_file_is_named(tmp_path):
    files.write(files.bnt(), tmp_path)
    (tmp_path / "bs000_N_N_0.lm3").write_text("Nose tip\n1 2\nx y 3\n1 2 3 4\n")
    with pytest.raises(ScanError, match=r"bs000_N_N_0\.lm3"):
        datasets.bosphorus(tmp_path)
    assert datasets.bosphorus(tmp_path, landmarks=False)[0].subject == "bs000"


def test_a_broken_pose_file_is_named(tmp_path):
    (tmp_path / "01").mkdir()
    files.write(files.biwi(), tmp_path / "01")
    (tmp_path / "01/frame_00003_pose.txt").write_text("1 0 0")
    with pytest.raises(ScanError, match=r"frame_00003_pose\.txt"):
        datasets.biwi(tmp_path)


@pytest.mark.parametrize("name", sorted(datasets.DATABASES))
def test_a_folder_that_is_not_there(name, tmp_path):
    with pytest.raises(ScanError):
        datasets.DATABASES[name].index(tmp_path / "none")


def test_an_index_that_is_no_text(tmp_path):
    (tmp_path / "index.csv").write_bytes(b"path,subject,role\n\xff\xfe,a,probe\n")
    with pytest.raises(ScanError, match=r"index\.csv"):
        datasets.folder(tmp_path)
