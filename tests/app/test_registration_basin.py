"""The experiment on finding and registering runs from end to end."""

import json

import pytest

from rangeface.evaluation.experiments import registration_basin


@pytest.mark.slow
def test_a_small_run_counts_everything_and_draws(tmp_path):
    result = registration_basin.run(people=2, face_free=6, basin_people=1)
    for table in result["poses"].values():
        assert table["nose"]["frontal"][1] == table["nose, registered"]["frontal"][1] == 2
        for method in registration_basin.REGISTERED:
            turned = set(registration_basin.POSES) - {"frontal"}
            assert set(table[f"pair, {method}"]) == turned
    middle = len(registration_basin.START_ANGLES) // 2
    assert result["basin"]["success"][middle][middle] == 1.0
    assert sum(result["face_free"]["scenes"].values()) == 6
    assert json.loads(json.dumps(result))["people"] == 2
    registration_basin.draw(result, tmp_path / "basin.png")
    assert (tmp_path / "basin.png").stat().st_size > 1000
