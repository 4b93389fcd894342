"""What the simulator puts in, the calibration takes out."""

from dataclasses import replace

import numpy as np
import pytest

from rangeface import sensors, simulate
from rangeface.sensors import Calibration
from rangeface.types import Pinhole

CAMERA = Pinhole(100.0, 100.0, 31.5, 23.5, 64, 48)
SENSOR = replace(
    sensors.preset("sr3000").ideal(),
    camera=CAMERA,
    third_harmonic=0.015,
    fixed_pattern_mm=3.0,
    gain_pattern=0.03,
    vignetting=4.0,
    shot_noise=1.0,
)
DISTANCES = np.arange(300.0, 2500.0, 60.0)


def plane(distance, seed, sensor=SENSOR):
    scene = simulate.render(simulate.wall(distance), sensor.camera)
    return simulate.tof(scene, sensor, rng=np.random.default_rng(seed))


@pytest.fixture(scope="module")
def calibration():
    quiet = replace(SENSOR, shot_noise=0.0)
    frames = [plane(z, i, quiet) for i, z in enumerate(DISTANCES)]
    return sensors.calibrate(frames, DISTANCES)


def test_corrected_frames_come_back_within_the_noise(calibration):
    for seed, distance in enumerate((420.0, 777.0, 1333.0)):
        raw = plane(distance, 100 + seed)
        corrected = calibration.apply(raw)
        before, after = ((i.depth - distance) / i.sigma for i in (raw, corrected))
        assert np.sqrt(np.mean(after**2)) == pytest.approx(1.0, abs=0.1)
        if distance < 500:
            assert np.sqrt(np.mean(before**2)) > 1.5


def test_the_map_and_the_curve_are_the_simulators(calibration):
    wiggle_mm = SENSOR.ambiguity_mm / (2 * np.pi) * 0.015
    assert np.ptp(calibration.wiggle_mm) == pytest.approx(2 * wiggle_mm, rel=0.15)
    assert calibration.offset_mm.std() == pytest.approx(3.0, rel=0.05)


def test_the_gain_map_flattens_the_amplitude(calibration):
    raw = plane(800.0, 7)
    ray = CAMERA.radial_factor()
    before, after = (i.amplitude * ray**2 for i in (raw, calibration.apply(raw)))
    lobe = (ray**-SENSOR.lobe_power) / (ray**-SENSOR.lobe_power).mean()
    assert lobe.std() > 0.01  # the emitter's lobe is part of the map
    assert after.std() / after.mean() < 0.2 * before.std() / before.mean()


def test_a_calibration_is_one_file(calibration, tmp_path):
    calibration.save(tmp_path / "specimen.npz")
    again = Calibration.load(tmp_path / "specimen.npz")
    for name in ("offset_mm", "range_mm", "wiggle_mm", "gain"):
        np.testing.assert_array_equal(getattr(again, name), getattr(calibration, name))


def test_distances_beyond_the_curve_keep_its_end(calibration):
    far = plane(DISTANCES[-1] + 300.0, 5)
    assert np.isfinite(calibration.apply(far).depth).all()
