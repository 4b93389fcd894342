"""Collections, phasor decoding, and what the experiments and the example make of them."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from rangeface import sensors, simulate
from rangeface.evaluation.experiments import figures_simulation, population_against_ict
from rangeface.numerics import phasor

SENSOR = sensors.preset("sr3000")


def test_a_collection_does_not_depend_on_its_workers():
    options = {"views": ["frontal1", "laugh", "left"], "oversample": 1, "seed": 3}
    one, three = (list(simulate.collection([2, 5], SENSOR, workers=w, **options)) for w in (1, 3))
    for a, b in zip(one, three, strict=True):
        assert (a.person, a.view) == (b.person, b.view)
        np.testing.assert_array_equal(a.image.depth, b.image.depth)


def test_the_views_turn_as_their_names_say():
    options = {"oversample": 1, "unrest_deg": 0.0}
    seen = {c.view: c for c in simulate.collection([1], SENSOR, **options)}
    assert set(seen) == set(simulate.VIEWS)
    angles = {v: np.degrees(c.pose.inverse().head_angles) for v, c in seen.items()}
    assert angles["left"][0] == pytest.approx(90.0)  # the subject's left is the image's right
    assert angles["right"][0] == pytest.approx(-90.0)
    assert angles["up"][1] < 0 < angles["down"][1]
    np.testing.assert_allclose(angles["laugh"], 0.0, atol=1e-9)
    assert (seen["frontal1"].image.depth != seen["frontal2"].image.depth).any()


@pytest.mark.parametrize("name", ["sr3000", "kinect-v2", "paper", "laser-scanner"])
def test_frames_are_captures_one_after_the_other(name):
    sensor = sensors.preset(name)
    view = simulate.render(simulate.head(0), sensor.camera, simulate.pose())
    rng = np.random.default_rng(4)
    expected = [simulate.capture(view, sensor, rng=rng) for _ in range(3)]
    run = simulate.frames(view, sensor, 3, rng=np.random.default_rng(4))
    for one, other in zip(run, expected, strict=True):
        np.testing.assert_array_equal(one.depth, other.depth)


@pytest.mark.parametrize("steps", [3, 4, 5, 8])
def test_decoding_is_exact_without_noise(steps):
    rng = np.random.default_rng(0)
    A, phase, B = rng.uniform(1, 50, (6, 7)), rng.uniform(-3, 3, (6, 7)), 200.0
    turn = 2 * np.pi * np.arange(steps)[:, None, None] / steps
    signal = phasor.decode(B + A * np.cos(phase + turn))
    np.testing.assert_allclose(np.abs(signal), A, rtol=1e-4)
    np.testing.assert_allclose(np.angle(signal), phase, atol=1e-4)


def test_unwrapping_survives_noise_far_below_half_a_step():
    L = np.array([1873.7, 9368.5])
    rng = np.random.default_rng(1)
    true = rng.uniform(100, 9000, (40, 50))
    phases = 2 * np.pi * (true[None] + rng.normal(0, 5, (2, 40, 50))) / L[:, None, None]
    assert np.abs(phasor.unwrap(phases, L, 9368.5) - true).max() < 40.0


def test_the_figures_are_drawn(tmp_path):
    files = figures_simulation.run(folder=tmp_path, seed=2)
    for file in files.values():
        assert Path(file).stat().st_size > 20_000


def test_the_experiment_measures_what_it_says():
    people = simulate.head
    mean = simulate.mean_head().surface.points
    apart = population_against_ict.distances(people, mean, 2)
    assert 1.0 < apart["by_closest_point_mm"] < apart["by_vertex_mm"] < 10.0
    same = population_against_ict.distances(lambda _seed: simulate.head(3), mean, 1)
    assert same["by_vertex_mm"] == pytest.approx(0.0, abs=1e-4)
    rates = population_against_ict.difficulty(
        lambda seed, **_: simulate.head(seed), people=8, nose_error_mm=0.0, seed=0
    )
    assert {r.rate for r in rates.values()} == {1.0}  # the probe is the gallery scan


def test_the_example_runs(capsys):
    script = Path(__file__).parents[2] / "examples" / "01_simulate.py"
    noise = runpy.run_path(str(script))["main"]()
    assert set(noise) == set(sensors.PRESETS)
    assert noise["laser-scanner"] < noise["kinect-v2"] < noise["sr3000"]
    assert "mm a pixel" in capsys.readouterr().out
