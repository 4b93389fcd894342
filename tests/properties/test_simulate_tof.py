"""The bucket model against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from rangeface import sensors, simulate
from rangeface.numerics import phasor
from rangeface.sensors import SensorModel
from rangeface.simulate import Scene
from rangeface.types import Orthographic, Pinhole

SIZE = 320
PLAIN = SensorModel("plain", "a test", Pinhole(1e6, 1e6, SIZE / 2, SIZE / 2, SIZE, SIZE), min_snr=0)


def flat(depth, *, reflectivity=1.0, camera=None, normal=(0.0, 0.0, -1.0)):
    camera = camera or PLAIN.camera
    depth = np.broadcast_to(np.float32(depth), (camera.height, camera.width))
    return Scene(
        camera,
        depth,
        np.broadcast_to(np.float32(normal), (*depth.shape, 3)),
        np.full(depth.shape, reflectivity, np.float32),
        np.zeros(depth.shape, np.float32),
        np.zeros(depth.shape, np.int16),
        np.zeros(depth.shape, np.int32),
    )


def wrapped_deviation(error, period):
    error = error - period * np.round(error / period)
    return error.std()


def capture_at(snr, *, phases=4, seed=0):
    """Range error (mm) at A/√B = snr; at 1 m the amplitude is the signal."""
    B = 4e6  # so large that the shot noise hardly varies between the buckets
    A = snr * np.sqrt(B)
    sensor = replace(
        PLAIN, signal=A, contrast=1.0, phases=phases, dark=max(B - A, 0.0), background=0.0
    )
    image = simulate.tof(flat(1000.0), sensor, rng=np.random.default_rng(seed))
    return image.depth.astype(float) - 1000.0, sensor, A, B


@pytest.mark.parametrize("snr", [7.0, 12.0, 40.0])
@pytest.mark.parametrize("phases", [3, 4, 6])
def test_range_deviation_is_lange_and_seitz_within_a_percent(snr, phases):
    error, sensor, A, B = capture_at(snr, phases=phases)
    L = sensors.SPEED_OF_LIGHT_MM_S / (2 * 20e6)
    law = L / (2 * np.pi) * np.sqrt(2 * B / phases) / A
    assert sensor.range_sigma(A, B) == pytest.approx(law)
    if phases == 4:
        assert law == pytest.approx(L * np.sqrt(B) / (2 * np.sqrt(2) * np.pi * A))
    assert wrapped_deviation(error, L) == pytest.approx(law, rel=0.012)


@pytest.mark.parametrize(("snr", "excess"), [(1.4, 0.21), (2.0, 0.11), (3.0, 0.035)])
def test_the_law_departs_as_the_angle_wraps(snr, excess):
    error, sensor, A, B = capture_at(snr)
    deviation = wrapped_deviation(error, sensor.ambiguity_mm)
    assert deviation / sensor.range_sigma(A, B) - 1 == pytest.approx(excess, abs=0.02)


def test_the_mean_phasor_is_unbiased_whatever_the_noise():
    sensor = replace(PLAIN, signal=40.0, contrast=1.0, dark=5000.0 - 40.0)
    raw = simulate.buckets(flat(1000.0), sensor, rng=np.random.default_rng(1))
    mean = phasor.decode(raw.counts)[0].astype(complex).mean()
    true = 40.0 * np.exp(2j * np.pi * 1000.0 / sensor.ambiguity_mm)
    standard_error = np.sqrt(2 * 5000.0 / 4) / SIZE
    assert abs(mean - true) < 4 * standard_error


@pytest.mark.parametrize(("phases", "order"), [(4, 4), (3, 3)])
def test_wiggling_repeats_as_often_as_there_are_buckets(phases, order):
    # the harmonic N − 1 aliases to −1 and beats with the fundamental at N per period
    name = {4: "third_harmonic", 3: "fifth_harmonic"}[phases]
    sensor = replace(PLAIN, phases=phases, shot_noise=0.0, **{name: 0.02})
    L = sensor.ambiguity_mm
    depth = np.linspace(0.05 * L, 0.95 * L, SIZE)[None, :].repeat(SIZE, axis=0)
    scene = flat(depth)
    image = simulate.tof(scene, sensor, rng=np.random.default_rng(0))
    wiggle = (image.depth - depth)[0]
    beat = order if phases == 4 else 6
    wave = np.exp(2j * np.pi * beat * depth[0] / L)
    strength = 2 * abs(np.mean((wiggle - wiggle.mean()) * wave))
    assert strength == pytest.approx(0.02 * L / (2 * np.pi), rel=0.12)
    assert np.ptp(wiggle) < 2.3 * strength  # nothing else is in it


def test_amplitude_law_is_exact_on_a_tilted_plane():
    camera = Pinhole(200.0, 210.0, 87.0, 71.0, 176, 144)
    sensor = SensorModel("lamp", "a test", camera, signal=5000.0, lobe_power=3.0)
    slope = np.array([0.4, -0.2])
    xy = 900.0 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    corners = np.column_stack([xy, 1200.0 + xy @ slope]).astype(np.float32)
    plane = simulate.wall(1.0)
    plane = type(plane)(corners, plane.triangles)
    scene = simulate.render(plane, camera)
    u, v = np.meshgrid(np.arange(176), np.arange(144))
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    z = 1200.0 / (1.0 - slope[0] * x - slope[1] * y)
    ray = np.sqrt(1 + x**2 + y**2)
    facing = 1.0 / np.sqrt(1.0 + slope @ slope)
    law = 5000.0 * 0.5 * facing * (1000.0 / (z * ray)) ** 2 * ray**-3.0
    np.testing.assert_allclose(simulate.amplitude(scene, sensor), law, rtol=2e-4)


@pytest.mark.parametrize("frequencies", [(80e6, 16e6), (60e6, 80e6), (200e6, 320e6)])
def test_two_frequencies_extend_the_range(frequencies):
    sensor = replace(PLAIN, frequencies_hz=frequencies, signal=1e6)
    depth = np.linspace(0.05, 0.95, SIZE)[None, :].repeat(SIZE, axis=0) * sensor.ambiguity_mm
    image = simulate.tof(flat(depth), sensor, rng=np.random.default_rng(0))
    assert sensor.ambiguity_mm > 1.5 * sensor.ambiguities_mm().max() or 16e6 in frequencies
    assert np.abs(image.depth - depth).max() < 30.0


def test_one_frequency_wraps():
    L = PLAIN.ambiguity_mm
    image = simulate.tof(flat(L + 500.0), replace(PLAIN, signal=1e7), rng=np.random.default_rng(0))
    assert image.depth.mean() == pytest.approx(500.0, abs=1.0)


def test_light_inside_a_pixel_mixes_as_phasors():
    camera = Orthographic(1.0, 0, 0, 1, 1)
    near, far = 500.0, 900.0
    fine = np.full((3, 3), near, np.float32)
    fine[:, 2] = far
    plane = flat(fine, camera=Orthographic(1.0, 0, 0, 3, 3))
    scene = replace(plane, camera=camera, oversample=3)
    sensor = replace(PLAIN, shot_noise=0.0)
    image = simulate.tof(scene, sensor, rng=np.random.default_rng(0))
    k = 2 * np.pi / sensor.ambiguity_mm
    mixture = 2 / near**2 * np.exp(1j * k * near) + 1 / far**2 * np.exp(1j * k * far)
    assert image.depth[0, 0] == pytest.approx(np.angle(mixture) / k, abs=0.01)
    assert near < image.depth[0, 0] < far


def test_global_multipath_pulls_everything_towards_the_mean_light():
    depth = np.full((SIZE, SIZE), 600.0)
    depth[:, 240:] = 1500.0
    sensor = replace(PLAIN, shot_noise=0.0, multipath=0.05)
    image = simulate.tof(flat(depth), sensor, rng=np.random.default_rng(0))
    assert image.depth[0, 0] == pytest.approx(600.0, abs=3.0)
    assert image.depth[0, -1] < 1500.0 - 10.0


def test_scattering_spreads_a_bright_foreground_over_the_background():
    depth = np.full((SIZE, SIZE), 3000.0)
    depth[:, :160] = 400.0
    sensor = replace(PLAIN, shot_noise=0.0, scattering=0.05, scattering_px=15.0)
    image = simulate.tof(flat(depth), sensor, rng=np.random.default_rng(0))
    error = image.depth[160] - 3000.0
    assert error[165] < error[185] < error[220] < 1e-3
    assert error[165] < -200.0


def test_motion_between_buckets_is_an_error_of_range():
    sensor = replace(PLAIN, shot_noise=0.0)
    scenes = [flat(1000.0 + 8.0 * k) for k in range(4)]
    moving = simulate.tof(scenes, sensor, rng=np.random.default_rng(0)).depth.mean()
    z = 1000.0 + 8.0 * np.arange(4)
    A = sensor.signal * (1000.0 / z) ** 2
    k = 2 * np.pi / sensor.ambiguity_mm
    counts = A / sensor.contrast + A * np.cos(k * z + np.pi / 2 * np.arange(4))
    expected = np.angle(phasor.decode(counts.reshape(4, 1, 1))).item() / k
    assert moving == pytest.approx(expected, abs=0.1)
    assert abs(moving - 1000.0) > 4.0


@pytest.mark.parametrize("bits", [8, 10, 12])
def test_the_converter_rounds(bits):
    sensor = replace(PLAIN, signal=1000.0, shot_noise=0.0, full_well=8000.0, bits=bits)
    raw = simulate.buckets(flat(1000.0), sensor, rng=np.random.default_rng(0)).counts
    steps = raw / sensor.converter_step
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-3)


def test_a_saturated_pixel_is_invalid():
    sensor = replace(PLAIN, signal=1000.0, full_well=2500.0)
    assert not simulate.tof(flat(1000.0), sensor, rng=np.random.default_rng(0)).mask.any()
    assert simulate.tof(flat(2000.0), sensor, rng=np.random.default_rng(0)).mask.all()


def test_compression_bends_bright_buckets():
    sensor = replace(PLAIN, signal=1000.0, shot_noise=0.0, full_well=1e4)
    straight = simulate.buckets(flat(1000.0), sensor, rng=np.random.default_rng(0)).counts
    bent = simulate.buckets(
        flat(1000.0), replace(sensor, compression=0.1), rng=np.random.default_rng(0)
    ).counts
    np.testing.assert_allclose(bent, straight * (1 - 0.1 * straight / 1e4), rtol=1e-5)


def test_dead_pixels_and_fixed_pattern_belong_to_the_specimen():
    sensor = replace(PLAIN, shot_noise=0.0, dead_pixels=0.01, fixed_pattern_mm=3.0)
    one, again = (
        simulate.tof(flat(1000.0), sensor, rng=np.random.default_rng(seed)) for seed in (0, 1)
    )
    np.testing.assert_array_equal(one.depth, again.depth)
    other = simulate.tof(flat(1000.0), replace(sensor, device=5), rng=np.random.default_rng(0))
    assert 0.005 < 1 - one.mask.mean() < 0.015
    assert np.nanstd(one.depth) == pytest.approx(3.0, rel=0.02)
    assert (one.mask != other.mask).any()


def test_read_noise_adds_to_shot_noise():
    sensor = replace(PLAIN, signal=2000.0, contrast=0.5, read_noise=50.0)
    image = simulate.tof(flat(1000.0), sensor, rng=np.random.default_rng(0))
    law = sensor.ambiguity_mm / (2 * np.pi) * np.sqrt((4000.0 + 50.0**2) / 2) / 2000.0
    assert image.depth.std() == pytest.approx(law, rel=0.012)
    assert image.sigma.mean() == pytest.approx(law, rel=0.01)


def test_jitter_is_common_to_a_frame_and_modulation_error_to_a_bucket():
    sensor = replace(PLAIN, shot_noise=0.0, jitter_rad=0.01)
    means = []
    for seed in range(40):
        image = simulate.tof(flat(1000.0), sensor, rng=np.random.default_rng(seed))
        assert image.depth.std() < 0.01
        means.append(image.depth.mean())
    law = 0.01 * sensor.ambiguity_mm / (2 * np.pi)
    assert np.std(means) == pytest.approx(law, rel=0.35)
    uneven = replace(PLAIN, shot_noise=0.0, modulation_error=0.01)
    image = simulate.tof(flat(1000.0), uneven, rng=np.random.default_rng(0))
    assert image.depth.std() < 0.01
    assert abs(image.depth.mean() - 1000.0) > 0.1


def test_a_hollow_looks_deeper_by_its_second_bounce():
    v, u = np.mgrid[:SIZE, :SIZE]
    bowl = 1000.0 + 25.0 * np.exp(-((u - 160) ** 2 + (v - 160) ** 2) / (2 * 8.0**2))
    sensor = replace(PLAIN, shot_noise=0.0, bounce=0.2)
    image = simulate.tof(flat(bowl), sensor, rng=np.random.default_rng(0))
    assert abs(image.depth[10, 10] - 1000.0) < 0.1
    assert image.depth[160, 160] - bowl[160, 160] > 0.5


@pytest.mark.parametrize("effect", sorted(sensors.EFFECTS))
def test_every_effect_switches_off_alone(effect):
    sensor = sensors.preset("sr3000")
    without = sensor.without(effect)
    changed = {name for name in vars(sensor) if getattr(sensor, name) != getattr(without, name)}
    assert changed == set(sensors.EFFECTS[effect])


def test_with_every_effect_off_the_truth_comes_out():
    sensor = sensors.preset("sr3000").ideal()
    scene = simulate.render(simulate.head(1), sensor.camera, simulate.pose(yaw_deg=20.0))
    image = simulate.tof(scene, sensor, rng=np.random.default_rng(0))
    assert np.nanmax(np.abs(image.depth - scene.image.depth)) < 0.01


def test_vignetting_and_lobe_dim_the_corners():
    sensor = sensors.preset("sr3000").ideal()
    scene = simulate.render(simulate.wall(1000.0), sensor.camera)
    rng = np.random.default_rng(0)
    ray = sensor.camera.radial_factor()
    plain = simulate.tof(scene, sensor, rng=rng).amplitude
    dim = simulate.tof(scene, replace(sensor, vignetting=4.0), rng=rng).amplitude
    np.testing.assert_allclose(dim / plain, ray**-4.0, rtol=1e-3)
