"""The command line as a user meets it: answers, exit statuses, one line for a mistake."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from rangeface import datasets
from rangeface.config import load_pipeline
from rangeface.evaluation import synthetic
from rangeface.evaluation.protocol import acquire
from rangeface.recognizer import FaceRecognizer

PEOPLE = range(70, 82)


@pytest.fixture(scope="module")
def model(tmp_path_factory, folder: Path) -> Path:
    way = load_pipeline("full-n-mlda")
    scans = [s for s in datasets.folder(folder) if s.role == "gallery"]
    traces = [c.trace for c in acquire(way, scans)]
    fitted = FaceRecognizer.fit_traces(way, traces, [s.subject for s in scans])
    templates = [fitted.template(t) for t in traces]
    path = tmp_path_factory.mktemp("model") / "door.model"
    fitted.calibrate(templates, [s.subject for s in scans]).save(path)
    return path


def test_enroll_list_identify_verify_delete(rangeface, folder, model, tmp_path) -> None:
    gallery = tmp_path / "door.db"
    options = ("--gallery", gallery, "--model", model)
    for person in (70, 71, 72):
        status, out, _ = rangeface("enroll", person, folder / f"{person}-gallery.npz", *options)
        assert (status, f"enrolled {person}" in out) == (0, True)
    assert rangeface("list", "--gallery", gallery)[1].split() == ["70", "1", "71", "1", "72", "1"]
    status, out, _ = rangeface("identify", folder / "71-probe.npz", *options, "--fmr", 0.2)
    assert out.splitlines()[2].split()[-1] == "71"
    status, out, _ = rangeface("verify", 71, folder / "71-probe.npz", *options, "--fmr", 0.2)
    assert (status, "accepted 71" in out) == (0, True)
    assert rangeface("delete", 71, "--gallery", gallery)[0] == 0
    status, _, err = rangeface("verify", 71, folder / "71-probe.npz", *options, "--fmr", 0.2)
    assert (status, "'71' is not enrolled" in err) == (2, True)


def test_evaluate_a_folder_writes_rates_with_intervals(rangeface, folder, tmp_path) -> None:
    target = tmp_path / "out.json"
    status, out, _ = rangeface(
        "evaluate", "folder", folder, "--pipeline", "full-n-mlda", "--json", target,
        "--exclude", "81",
    )  # fmt: skip
    assert status == 0
    result = json.loads(target.read_text())
    assert set(result) == {
        "dataset", "pipeline", "excluded", "fingerprint", "ms_per_scan", "subset",
    }  # fmt: skip
    everyone = result["subset"]["all"]
    assert everyone["n"] == len(PEOPLE) - 1
    assert 0 <= everyone["rank1"]["low"] <= everyone["rank1"]["rate"] <= 1
    assert {"rank5", "eer", "fta"} <= set(everyone)
    pairs = everyone["n"] * (everyone["n"] - 1)
    assert everyone["fnmr_at_fmr"]["fmr"] == pytest.approx(max(0.01, 3 / pairs))
    assert "rank 1" in out


def test_a_broken_file_among_many_is_counted_and_the_run_goes_on(rangeface, folder) -> None:
    broken = folder / "75-probe.npz"
    whole = broken.read_bytes()
    broken.write_bytes(whole[: len(whole) // 2])
    try:
        status, out, _ = rangeface("evaluate", "folder", folder, "--pipeline", "full-n-mlda")
    finally:
        broken.write_bytes(whole)
    assert status == 0
    assert "75-probe.npz" in out
    assert "1 of 24 captures failed" in out


def test_a_false_match_rate_that_nobody_can_show_is_refused(rangeface, folder) -> None:
    status, _, err = rangeface("evaluate", "folder", folder, "--fmr", 1e-5)
    assert status == 2
    assert "cannot be shown with 132 comparisons" in err


def test_info_and_trace_of_a_file(rangeface, folder, tmp_path) -> None:
    status, out, _ = rangeface("info", folder / "70-gallery.npz")
    assert status == 0
    assert "176 × 144 px" in out
    assert "yaw" in out
    picture = tmp_path / "trace.png"
    assert rangeface("trace", folder / "70-gallery.npz", "--out", picture)[0] == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


MISTAKES = {
    "missing file": (("info", "nowhere.npz"), "nowhere.npz: file not found"),
    "missing folder": (("evaluate", "folder", "nowhere"), "nowhere"),
    "unknown preset": (("evaluate", "synthetic", "--pipeline", "magic"), "unknown preset 'magic'"),
    "unknown sensor": (("evaluate", "synthetic", "--sensor", "magic"), "unknown preset 'magic'"),
    "missing gallery": (("list", "--gallery", "nowhere.db"), "no such gallery"),
    "missing model": (
        ("identify", "x.npz", "--gallery", "g.db", "--model", "nowhere.model"),
        "nowhere.model: file not found",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_line_and_exit_status_2(name, rangeface, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    args, message = MISTAKES[name]
    status, _, err = rangeface(*args)
    assert status == 2
    assert message in err
    assert err.count("\n") == 1
    assert "Traceback" not in err


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys, rangeface.app.cli; "
        "print([m for m in ('numba', 'sklearn', 'cv2', 'matplotlib', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_simulated_captures_are_the_same_every_time() -> None:
    first, second = (synthetic.scans(people=1, frames=1)[1].load()[0] for _ in range(2))
    assert first.depth.tobytes() == second.depth.tobytes()
