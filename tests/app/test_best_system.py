"""`default` meets what the paper's methods meet, and pays for faces that it does not find."""

from dataclasses import replace

import numpy as np
import pytest

from rangeface.evaluation.experiments import best_system, models, table6, table7, table8
from rangeface.evaluation.experiments._experiment import hits
from rangeface.evaluation.experiments.sources import scans_of, source
from rangeface.evaluation.experiments.stages import pack
from rangeface.evaluation.grid import Store, cell, key


def blinded(store, *, people, view, blind):
    """Scans of a view; that of person `blind`, if there is one, shows nothing."""
    images = [
        image.with_depth(np.full(image.shape, np.nan)) if person == blind else image
        for person, image in scans_of(source(persons=people), view)
    ]
    return {"owner": np.arange(people), **pack(images)}


def params(one, *names):
    found = dict(one.params)
    return found if not names else params(found[names[0]], *names[1:])


def test_every_setting_takes_a_cell_of_its_table():
    people = source(persons=60)
    theirs = {key(c) for t in (table6, table7) for c in t.cells(people)}
    theirs |= {key(c) for c in table8.cells(replace(people, persons=24))}
    settings = best_system.settings(people)
    assert {key(setting.paper) for setting in settings} <= theirs
    assert len(settings) == 2 + 2 * len(table7.LEVELS) + 2


def test_the_paper_prints_no_higher_number_than_its_best():
    best = {(s.name[:7], s.probe): s.printed for s in best_system.settings(source(persons=2))[:2]}
    assert best == {("table 6", "neutral"): 92, ("table 6", "smiling"): 90}
    noisy = best_system.settings(source(persons=2))[2:10]
    assert [s.printed for s in noisy] == [87, 78, 73, 58, 58, 58, 57, 58]
    assert [s.printed for s in best_system.settings(source(persons=2))[10:]] == [83, 83]


def test_default_sees_the_noise_that_the_papers_method_sees():
    noisy = [s for s in best_system.settings(source(persons=3, seed=5)) if "dB" in s.name]
    for setting in noisy:
        ours, theirs = params(setting.default, "probes"), params(setting.paper, "probes")
        assert all(ours[name] == theirs[name] for name in ("scans", "sigma_mm", "seed"))


def test_another_model_never_meets_the_results_of_this_one(monkeypatch):
    kept = {key(s.default) for s in best_system.settings(source(persons=2))}
    monkeypatch.setattr(models, "shipped", lambda: "f" * 64)
    assert not kept & {key(s.default) for s in best_system.settings(source(persons=2))}


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("cells"))


def recognised(store, *, enrolled=None, probed=None):
    """Three people, one of whom shows no face when they are enrolled or come again."""
    model = models.shipped()

    def templates(view, blind, augment):
        seen = cell(blinded, people=3, view=view, blind=blind)
        return cell(best_system.of_scans, scans=seen, model=model, augment=augment)

    known, came = templates("frontal1", enrolled, True), templates("frontal2", probed, False)
    return store.get(cell(best_system.recognised, model=model, enrolled=(known,), probes=came))


def test_a_probe_without_a_face_is_an_error(store):
    result = recognised(store, probed=1)
    assert np.isnan(result["scores"][1]).all()
    assert np.isfinite(result["scores"][[0, 2]]).all()
    assert hits(result).tolist() == [True, False, True]


def test_a_person_who_was_not_enrolled_is_an_error(store):
    result = recognised(store, enrolled=0)
    assert np.isnan(result["scores"][..., 0]).all()
    assert hits(result).tolist() == [False, True, True]
