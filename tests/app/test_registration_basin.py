"""The experiment on finding and registering: its cells, and what a small one finds."""

from dataclasses import replace

import numpy as np
import pytest

from rangeface.evaluation.experiments import registration_basin
from rangeface.evaluation.experiments.face_free import KINDS
from rangeface.evaluation.experiments.registration_basin import (
    MEASURED,
    MOST_SCENES,
    START_ANGLES,
    basin_of,
    faces_found,
    scanned,
    scans_of,
    scenes_of,
)
from rangeface.evaluation.experiments.sources import source
from rangeface.evaluation.grid import Store, cell


def numbers(cells):
    """The numbers of the scenes of cells."""
    params = [one.all_params() for one in cells]
    step = len(KINDS)
    return [p["first"] + step * k for p in params for k in range(p["count"])]


def test_everybody_is_scanned_once_in_each_noise():
    for noise in registration_basin.NOISES:
        params = [one.all_params() for one in scans_of(source(persons=20, seed=2), noise)]
        people = [p["first"] + k for p in params for k in range(p["count"])]
        assert people == list(range(2001, 2021))


@pytest.mark.parametrize(("persons", "total"), [(3, 252), (24, MOST_SCENES)])
def test_kinds_of_scenes_take_turns(persons, total):
    people = source(persons=persons)
    shown = {kind: numbers(scenes_of(people, kind)) for kind in KINDS}
    assert sorted(n for of_kind in shown.values() for n in of_kind) == list(range(total))
    for place, of_kind in enumerate(shown.values()):
        assert {n % len(KINDS) for n in of_kind} == {place}


def test_another_population_shares_scenes_and_basin():
    own = source(persons=4)
    ict = replace(own, kind="ict", folder="somewhere", identity="other")
    assert len(basin_of(source(persons=60))) == 3
    assert basin_of(own) == basin_of(ict) == basin_of(source(persons=60))[:1]
    assert all(scenes_of(own, kind) == scenes_of(ict, kind) for kind in KINDS)
    assert not set(scans_of(own, "clean")) & set(scans_of(ict, "clean"))


@pytest.mark.slow
def test_a_clean_scan_is_found_and_registered_in_every_pose(tmp_path):
    found = Store(tmp_path).get(
        cell(scanned, source=source(persons=2), noise="clean", first=1, count=1)
    )
    assert {what: flags.shape for what, flags in found.items()} == {
        what: (1, len(poses)) for what, poses in MEASURED.items()
    }
    assert all(flags.all() for flags in found.values())


@pytest.mark.slow
def test_a_start_that_is_right_arrives(tmp_path):
    arrived = Store(tmp_path).get(basin_of(source(persons=2))[0])["arrived"]
    middle = len(START_ANGLES) // 2
    assert arrived.shape == (len(START_ANGLES), len(START_ANGLES))
    assert arrived[middle, middle]


def test_no_face_is_found_in_walls(tmp_path):
    one = cell(faces_found, source=source(persons=2), kind="wall", first=0, count=2)
    assert np.array_equal(Store(tmp_path).get(one)["found"], [False, False])
