"""Theorems about the combination of frames."""

import weakref

import numpy as np
import pytest

from rangeface.denoise import combine
from rangeface.types import Pinhole, RangeImage, RigidTransform

CAMERA = Pinhole(200, 200, 15.5, 11.5, 32, 24)
LIGHT_MM_PER_S = 299_792_458_000.0


def noisy_frames(n, seed, sigma=2.0):
    rng = np.random.default_rng(seed)
    shape = (24, 32)
    for _ in range(n):
        depth = 500.0 + rng.normal(0.0, sigma, shape)
        yield RangeImage(
            depth, CAMERA, sigma=np.full(shape, sigma), amplitude=np.full(shape, 100.0)
        )


@pytest.mark.parametrize("method", [combine.mean, combine.phasor_mean])
@pytest.mark.parametrize("seed", range(5))
def test_ten_frames_cut_the_noise_by_root_ten_and_say_so(method, seed):
    """σ of the mean of n independent values is σ/√n."""
    out = method(noisy_frames(10, seed))
    assert np.std(out.depth - 500.0) == pytest.approx(2.0 / np.sqrt(10), rel=0.15)
    np.testing.assert_allclose(out.sigma, 2.0 / np.sqrt(10), rtol=1e-3)


def test_the_phasor_mean_of_still_frames_is_their_range():
    """Radial, not depth: off axis too the depth comes back unchanged."""
    frame = next(noisy_frames(1, 0))
    out = combine.phasor_mean([frame] * 7, frequency_hz=30e6)
    np.testing.assert_allclose(out.depth, frame.depth, atol=1e-3)
    np.testing.assert_allclose(out.amplitude, 100.0, rtol=1e-5)


def test_a_wrapped_frame_does_not_drag_the_phasor_mean_along():
    """0 mm and c/2f are the same phase: their phasor mean is not half-way."""
    period = LIGHT_MM_PER_S / (2 * 20e6)
    camera = Pinhole(200, 200, 0, 0, 1, 1)
    frames = [
        RangeImage([[z]], camera, amplitude=[[50.0]]) for z in (20.0, 20.0, period - 20.0, 20.0)
    ]
    depth = float(combine.phasor_mean(frames, frequency_hz=20e6).depth[0, 0])
    assert depth % period == pytest.approx(10.0, abs=0.1)
    assert float(combine.mean(frames).depth[0, 0]) > 1000.0


def test_data_beyond_the_first_period_keep_their_range():
    camera = Pinhole(200, 200, 0, 0, 1, 1)
    frames = [RangeImage([[z]], camera) for z in (9000.0, 9002.0)]
    assert combine.phasor_mean(frames, frequency_hz=20e6).depth[0, 0] == pytest.approx(
        9001, abs=0.1
    )


@pytest.mark.parametrize("seed", range(3))
def test_phasors_beat_depths_where_light_is_scarce(seed):
    """FACTS: at low SNR phases wrap; phasors then have the smaller bias and error."""
    rng = np.random.default_rng(seed)
    f, A, B, truth = 20e6, 40.0, 5000.0, 1000.0
    camera = Pinhole(1e6, 1e6, 0, 0, 40, 40)
    phase = 4 * np.pi * f / LIGHT_MM_PER_S * truth
    frames = []
    for _ in range(10):
        q = [rng.poisson(B + A * np.cos(phase + k * np.pi / 2), (40, 40)) for k in range(4)]
        measured = ((q[0] - q[2]) + 1j * (q[3] - q[1])) / 2
        depth = np.mod(np.angle(measured), 2 * np.pi) * LIGHT_MM_PER_S / (4 * np.pi * f)
        frames.append(RangeImage(depth, camera, amplitude=np.abs(measured)))
    period = LIGHT_MM_PER_S / (2 * f)

    def error(image):
        return np.mod(image.depth - truth + period / 2, period) - period / 2

    by_phasor, by_depth = error(combine.phasor_mean(frames)), error(combine.mean(frames))
    assert np.abs(by_phasor.mean()) < np.abs(by_depth.mean())
    assert np.sqrt(np.mean(by_phasor**2)) < np.sqrt(np.mean(by_depth**2))


@pytest.mark.parametrize("name", combine.COMBINE)
def test_memory_does_not_grow_with_the_number_of_frames(name):
    """A stream is read once; besides the first frame only the last two are alive."""
    seen: list[weakref.ref] = []

    def stream():
        for frame in noisy_frames(20, 0):
            assert sum(ref() is not None for ref in seen) <= 3
            seen.append(weakref.ref(frame))
            yield frame
            del frame

    still = [RigidTransform(np.eye(3), np.zeros(3))] * 20
    combine.COMBINE[name](stream(), poses=still)
    assert len(seen) == 20


def test_filled_pixels_are_not_measurements():
    camera = Pinhole(200, 200, 0, 0, 2, 1)
    real = RangeImage([[500.0, np.nan]], camera)
    guess = RangeImage([[600.0, 600.0]], camera, filled=[[True, True]])
    for method in (combine.mean, combine.phasor_mean):
        out = method([real, guess])
        assert out.depth[0, 0] == pytest.approx(500.0)
        assert not out.mask[0, 1]
