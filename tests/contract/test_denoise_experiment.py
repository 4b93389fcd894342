"""The experiment `denoise_by_recognition` pairs by person; its figures are drawn."""

import numpy as np
import pytest

from rangeface.evaluation.experiments import denoise_by_recognition as experiment
from rangeface.evaluation.experiments import figures_denoise, noisy_captures
from rangeface.evaluation.experiments._experiment import results_of
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.grid import Store

PEOPLE = Source("synthetic", 3, 0, "", "any")


def test_findings_have_a_row_a_cell_and_a_picture(monkeypatch, tmp_path):
    for table, names in (("LEVELS", ("crop 34 dB", "tof 4 mm")), ("DENOISERS", ("none", "auto"))):
        whole = getattr(experiment, table)
        monkeypatch.setattr(experiment, table, {name: whole[name] for name in names})
    assert len(experiment.cells(PEOPLE)) == 4
    findings = experiment.tabulate(PEOPLE, results_of(Store(tmp_path)))
    auto, clean, matched = findings.tables
    assert len(auto.rows) == 2
    assert len(clean.rows) == len(matched.rows) == 4
    assert all(len(row) == len(clean.header) for row in clean.rows)
    assert len(findings.figures[0][1]) > 10_000


def test_the_difference_is_paired_by_person():
    # one of the four results of the first of two people
    better, worse = np.ones((1, 1, 2, 4), bool), np.ones((1, 1, 2, 4), bool)
    worse[0, 0, 1, 0] = False
    gain, low, high = experiment.difference({"hits": better}, {"hits": worse}, 0)
    assert gain == pytest.approx(12.5)
    assert low == pytest.approx(0.0)
    assert high == pytest.approx(25.0)


def test_every_person_and_capture_is_reproducible():
    first, second = (noisy_captures.taken(noisy_captures.own_heads(), 5, 3) for _ in range(2))
    np.testing.assert_array_equal(first.scan.depth, second.scan.depth)
    np.testing.assert_array_equal(first.frontal.depth, second.frontal.depth)


def test_figures_10_and_12_are_drawn(tmp_path):
    for path in figures_denoise.draw(tmp_path):
        assert path.stat().st_size > 10_000
