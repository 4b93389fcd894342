"""Unwrapping: it undoes any wrap of a smooth image, and agrees modulo the period always."""

import numpy as np
import pytest

from rangeface.numerics.unwrap import unwrap_2d


@pytest.mark.parametrize("seed", range(8))
def test_itoh_a_smooth_image_comes_back_whatever_its_holes(seed):
    """Itoh 1982, doi:10.1364/AO.21.002470: steps below half a period determine the image."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[:40, :50]
    a, b, c = rng.uniform(0.5, 1.5, 3)
    smooth = 4 * np.sin(a * u / 15) + 4 * np.cos(b * v / 13) + c * u / 10
    smooth[rng.random(smooth.shape) < 0.1] = np.nan
    out = unwrap_2d(smooth % 2.0, period=2.0)
    difference = (out - smooth)[np.isfinite(smooth)]
    turns = np.rint(difference / 2.0)
    assert np.abs(difference - 2 * turns).max() < 1e-9
    assert (turns != np.median(turns)).mean() < 0.02  # islands cut off by holes are free


def test_noise_stays_the_same_modulo_the_period():
    noise = np.random.default_rng(1).random((20, 30))
    out = unwrap_2d(noise, period=1.0)
    assert np.allclose(out % 1.0, noise)


def test_nothing_known_gives_nothing():
    assert np.isnan(unwrap_2d(np.full((3, 4), np.nan), period=1.0)).all()
