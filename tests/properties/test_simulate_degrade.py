"""Degrading steps do what their numbers say."""

import numpy as np
import pytest

from rangeface import simulate
from rangeface.types import Orthographic, Pinhole, RangeImage


def slope(height=240, width=320, camera=None):
    v, u = np.mgrid[:height, :width]
    camera = camera or Orthographic(0.5, 100.0, 80.0, width, height)
    return RangeImage(400.0 + 0.05 * u - 0.02 * v, camera)


@pytest.mark.parametrize("psnr", [34.09, 38.52, 42.08, 48.05])
def test_psnr_is_the_one_asked_for(psnr):
    # the noise levels of the paper's table 7; peak 255 levels = 140 mm
    clean = slope()
    noisy = simulate.add_noise_psnr(clean, psnr, peak_mm=140.0, rng=np.random.default_rng(1))
    error = noisy.depth.astype(float) - clean.depth
    assert 20 * np.log10(140.0 / np.sqrt(np.mean(error**2))) == pytest.approx(psnr, abs=0.05)


def test_noise_goes_into_sigma():
    once = simulate.add_noise(slope(), 3.0, rng=np.random.default_rng(0))
    twice = simulate.add_noise(once, 4.0, rng=np.random.default_rng(1))
    np.testing.assert_allclose(twice.sigma, 5.0, rtol=1e-6)
    assert np.std(twice.depth - slope().depth) == pytest.approx(5.0, rel=0.02)


@pytest.mark.parametrize("factor", [1, 2, 3, 5])
@pytest.mark.parametrize("kind", [Orthographic, Pinhole])
def test_coarsening_keeps_a_slope_where_it_is(factor, kind):
    if kind is Orthographic:
        camera = Orthographic(0.5, 100.0, 80.0, 320, 240)
    else:
        camera = Pinhole(500.0, 480.0, 100.0, 80.0, 320, 240)
    clean = slope(camera=camera)
    coarse = simulate.coarsen(clean, factor)
    # the same linear function of the original pixel coordinates, read back through the camera
    rows, columns = np.mgrid[: coarse.shape[0], : coarse.shape[1]]
    u, v = (factor * n + 0.5 * (factor - 1) for n in (columns, rows))
    np.testing.assert_allclose(coarse.depth, 400.0 + 0.05 * u - 0.02 * v, atol=1e-3)
    one = coarse.camera.project(coarse.camera.back_project(coarse.depth)[4, 6])
    np.testing.assert_allclose(one, [6.0, 4.0], atol=1e-3)
    x = coarse.camera.back_project(coarse.depth)[4, 6, 0] / (
        1.0 if kind is Orthographic else coarse.depth[4, 6]
    )
    scale = 0.5 if kind is Orthographic else 1 / 500.0
    assert x == pytest.approx((u[4, 6] - 100.0) * scale, rel=1e-4)


def test_a_block_that_is_mostly_empty_stays_empty():
    depth = np.full((4, 4), 400.0)
    depth[:2, :2] = np.nan
    depth[0, 0] = 390.0
    depth[2, 2] = np.nan
    coarse = simulate.coarsen(RangeImage(depth, Orthographic(1.0, 0, 0, 4, 4)), 2)
    np.testing.assert_array_equal(coarse.mask, [[False, True], [True, True]])
    assert coarse.depth[1, 1] == 400.0


@pytest.mark.parametrize("share", [0.0, 0.02, 0.2, 0.7, 1.0])
def test_holes_cover_their_share(share):
    pierced = simulate.punch_holes(slope(), share, rng=np.random.default_rng(2))
    assert 1 - pierced.mask.mean() == pytest.approx(share, abs=0.02)


@pytest.mark.parametrize("step", [0.5, 1.0, 4.0])
def test_quantised_depths_are_multiples(step):
    rounded = simulate.quantise(slope(), step).depth
    np.testing.assert_allclose(rounded / step, np.round(rounded / step))
    assert np.abs(rounded - slope().depth).max() <= 0.5 * step + 1e-4


def test_the_way_down_is_in_order():
    clean = simulate.render(simulate.head(0), Orthographic(0.5, 120, 150, 240, 320)).image
    steps = simulate.degrade(clean, rng=np.random.default_rng(0))
    assert list(steps) == ["original", "resolution", "noise", "quantisation", "holes"]
    assert steps["resolution"].shape == (80, 60)
    noise = steps["noise"].depth - steps["resolution"].depth
    assert np.nanstd(noise) == pytest.approx(4.0, rel=0.1)
    assert steps["holes"].mask.sum() < steps["quantisation"].mask.sum()
