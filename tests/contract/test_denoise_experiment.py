"""The experiment `denoise_by_recognition` keeps its cells and sums them up; figures are drawn."""

import json

import numpy as np
import pytest

from rangeface.evaluation.experiments import denoise_by_recognition as experiment
from rangeface.evaluation.experiments import (
    denoise_report,
    figures_denoise,
    noisy_captures,
)


@pytest.fixture
def two_levels(monkeypatch):
    levels = {name: experiment.LEVELS[name] for name in ("crop 34 dB", "tof 4 mm")}
    monkeypatch.setattr(experiment, "LEVELS", levels)


def test_a_run_can_be_cut_short_and_taken_up_again(two_levels, tmp_path):
    asked = {"people": 3, "folder": tmp_path, "denoisers": ("none", "auto")}
    cut = experiment.run(minutes=0.0, **asked)
    assert cut["missing"] == 4
    assert not list(tmp_path.iterdir())
    whole = experiment.run(minutes=9.0, **asked)
    assert whole["missing"] == 0
    assert len(list(tmp_path.glob("*.json"))) == 4
    again = experiment.run(minutes=0.0, **asked)
    assert json.dumps(again) == json.dumps(whole)
    assert len(whole["auto_minus_none"]) == 2 * len(experiment.FEATURES)
    for cell in whole["cells"]:
        assert len(cell["rates"]) == len(experiment.FEATURES) * 2 * 2
        assert all(0.0 <= low <= rate <= high <= 1.0 for *_, rate, low, high in cell["rates"])


def test_the_difference_is_paired_by_person():
    hits = {"MLDA": {"clean": "1100", "matched": "1111"}}
    worse = {"MLDA": {"clean": "1100", "matched": "0111"}}
    done = {
        ("own", "crop 34 dB", "auto"): {"hits": {"N3": hits}},
        ("own", "crop 34 dB", "none"): {"hits": {"N3": worse}},
    }
    ((_, _, feature, gain, low, high),) = experiment.differences(done)
    assert feature == "N3"
    # one of the four results of the first of two people
    assert gain == pytest.approx(12.5)
    assert low == pytest.approx(0.0)
    assert high == pytest.approx(25.0)


def test_every_person_and_capture_is_reproducible():
    first, second = (noisy_captures.taken(noisy_captures.own_heads(), 5, 3) for _ in range(2))
    np.testing.assert_array_equal(first.scan.depth, second.scan.depth)
    np.testing.assert_array_equal(first.frontal.depth, second.frontal.depth)


def test_the_report_has_a_row_a_cell_and_a_picture(two_levels, tmp_path):
    result = experiment.run(people=2, folder=tmp_path, denoisers=("none", "auto"))
    table = denoise_report.table(result, population="own", training="clean")
    assert len(table.splitlines()) == 2 + 4
    path = denoise_report.draw(result, tmp_path / "picture.png", population="own")
    assert path.stat().st_size > 10_000


def test_figures_10_and_12_are_drawn(tmp_path):
    for path in figures_denoise.draw(tmp_path):
        assert path.stat().st_size > 10_000
