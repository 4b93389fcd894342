"""The random draws, the paper's model and the triangulating sensors against their laws."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from rangeface import sensors, simulate
from rangeface.numerics import draws


def test_normal_deviates_are_normal():
    z = draws.normal((1_000_001,), rng=np.random.default_rng(0))
    assert abs(z.mean()) < 4e-3
    assert z.std() == pytest.approx(1.0, abs=4e-3)
    assert stats.kstest(z, "norm").pvalue > 1e-3
    assert abs(stats.kurtosis(z)) < 0.02


@pytest.mark.parametrize("lag", [1, 176, 500_001])
def test_normal_deviates_are_uncorrelated(lag):
    z = draws.normal((1_000_001,), rng=np.random.default_rng(1))
    assert abs(np.corrcoef(z[:-lag], z[lag:])[0, 1]) < 5e-3


def test_the_key_decides():
    first, again, other = (
        draws.normal((7, 9), rng=np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


@pytest.mark.parametrize("mean", [0.0, 0.3, 5.0, 40.0, 64.0, 500.0, 2e4])
def test_poisson_counts_have_poisson_moments(mean):
    counts = draws.poisson(np.full(400_000, mean), rng=np.random.default_rng(3))
    np.testing.assert_array_equal(counts, np.round(counts))
    assert counts.min() >= 0
    assert counts.mean() == pytest.approx(mean, abs=5 * np.sqrt(mean / 4e5) + 1e-12)
    assert counts.var() == pytest.approx(mean, rel=0.015, abs=1e-12)
    if 0 < mean < 1000:
        assert stats.skew(counts) == pytest.approx(mean**-0.5, abs=0.03)


@pytest.mark.parametrize("amplitude", [0.0, 0.7, 2.0, 8.0, 60.0])
def test_the_angle_is_that_of_a_normal_point_in_the_plane(amplitude):
    rng = np.random.default_rng(4)
    angle, length = draws.angle_noise(np.full(200_000, amplitude), rng=rng)
    n = rng.standard_normal((2, 200_000))
    reference = np.arctan2(n[1], amplitude + n[0])
    assert stats.ks_2samp(angle, reference).pvalue > 1e-3
    assert stats.ks_2samp(length, np.hypot(n[1], amplitude + n[0])).pvalue > 1e-3


def test_the_angle_is_exact_to_the_last_bits_of_its_polynomial():
    angle, length = draws.angle_noise(np.full(50_000, 3.0), rng=np.random.default_rng(5))
    x = length * np.cos(angle.astype(float)) - 3.0
    y = length * np.sin(angle.astype(float))
    # what remains is the normal point itself, so its radius is Rayleigh
    assert stats.kstest(np.hypot(x, y), "rayleigh").pvalue > 1e-3


def test_the_papers_preset_follows_its_own_law():
    sensor = sensors.preset("paper")
    scene = simulate.render(simulate.wall(500.0), sensor.camera)
    errors, laws = [], []
    for seed in range(8):
        image = simulate.capture(scene, sensor, rng=np.random.default_rng(seed))
        errors.append(image.depth - scene.image.depth)
        laws.append(sensor.ambiguity_mm / (2 * np.pi) / simulate.amplitude(scene, sensor))
    standardised = np.array(errors) * sensor.camera.radial_factor() / np.array(laws)
    assert standardised.std() == pytest.approx(1.0, abs=0.01)
    assert abs(standardised.mean()) < 0.01


def test_a_weak_signal_of_the_papers_model_wraps():
    sensor = replace(sensors.preset("paper"), signal=1.0, min_snr=0.0)
    scene = simulate.render(simulate.wall(1000.0), sensor.camera)
    image = simulate.capture(scene, sensor, rng=np.random.default_rng(0))
    assert image.depth.std() > 0.8 * 1000
    assert np.nanmax(image.depth) > 5000.0


@pytest.mark.parametrize("depth", [500.0, 1000.0, 2000.0])
def test_a_triangulating_sensor_has_quadratic_noise_and_steps(depth):
    sensor = sensors.preset("structured-light")
    scene = simulate.render(simulate.wall(depth), sensor.camera)
    smooth = simulate.capture(scene, replace(sensor, step_per_mm=0.0), rng=np.random.default_rng(0))
    assert smooth.depth.std() == pytest.approx(1.425e-6 * depth**2, rel=0.01)
    stepped = simulate.capture(scene, sensor, rng=np.random.default_rng(0))
    levels = np.unique(stepped.depth)
    assert len(levels) < 20
    assert np.diff(levels).mean() == pytest.approx(2.85e-6 * depth**2, rel=0.05)
