"""Theorems about the denoisers."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rangeface import denoise
from rangeface.denoise import combine
from rangeface.numerics import banded, dwt, holes, noise, smoothing
from rangeface.numerics.dtcwt import quads, trees
from rangeface.numerics.se3 import rotation_matrix
from rangeface.types import Orthographic, Pinhole, RangeImage, RigidTransform

CAMERA = Orthographic(2.0, 25, 40, 50, 80)


def hill(shape=(80, 50)):
    """A smooth hill of 60 mm."""
    v, u = np.mgrid[: shape[0], : shape[1]]
    return 500.0 - 60.0 * np.exp(-((u - 25.0) ** 2 + (v - 40.0) ** 2) / 300.0)


def noisy(sigma, seed=0, *, known=True):
    depth = hill() + np.random.default_rng(seed).normal(0.0, sigma, (80, 50))
    return RangeImage(depth, CAMERA, sigma=np.full((80, 50), sigma) if known else None)


def rmse(image):
    return float(np.sqrt(np.nanmean((image.depth - hill()) ** 2)))


SMOOTHERS = [name for name in denoise.METHODS if name not in ("none", "flying_pixels")]


@pytest.mark.parametrize("name", SMOOTHERS)
@pytest.mark.parametrize("known", [True, False])
def test_every_smoother_takes_noise_from_a_smooth_surface(name, known):
    assert rmse(denoise.METHODS[name](noisy(3.0, known=known))) < 2.1


@pytest.mark.parametrize("sigma", [0.1, 0.5, 2.0, 8.0])
@pytest.mark.parametrize("seed", range(3))
def test_auto_never_adds_error(sigma, seed):
    assert rmse(denoise.auto(noisy(sigma, seed))) < sigma


@pytest.mark.parametrize("transform", [denoise.dwt, denoise.dtcwt])
@pytest.mark.parametrize(
    "parameters", [{"threshold_mm": 0.0}, {"shrinkage": "soft", "threshold_sigma": 0.0}]
)
def test_threshold_zero_is_the_identity(transform, parameters):
    """Eq. 3.5 at T = 0: not 0/0."""
    image = noisy(2.0)
    np.testing.assert_allclose(transform(image, **parameters).depth, image.depth, atol=2e-3)
    flat = RangeImage(np.full((80, 50), 500.0), CAMERA)
    np.testing.assert_allclose(transform(flat, **parameters).depth, 500.0, atol=2e-3)


@settings(max_examples=20, deadline=None)
@given(T=st.floats(0.0, 5.0), seed=st.integers(0, 2**32 - 1))
def test_soft_thresholding_of_quads_is_eq_3_5_on_the_complex_magnitude(T, seed):
    band = np.random.default_rng(seed).normal(0.0, 2.0, (6, 10)).astype(np.float32)
    z = np.stack(quads.to_complex(band))
    gain = np.maximum(np.abs(z) - T, 0.0) / np.abs(z)
    kept = quads.soft(band, np.full((3, 5), T, np.float32))
    np.testing.assert_allclose(np.stack(quads.to_complex(band)), gain * z, atol=1e-5)
    assert kept == pytest.approx(np.mean(gain**2), abs=1e-4)


def test_wiener_and_scale_of_quads_act_on_the_complex_magnitude():
    rng = np.random.default_rng(3)
    band, pilot = rng.normal(size=(2, 8, 6)).astype(np.float32)
    z, x = np.stack(quads.to_complex(band)), np.stack(quads.to_complex(pilot))
    gain = np.abs(x) ** 2 / (np.abs(x) ** 2 + 2.0 * 0.7**2)
    scaled = band.copy()
    quads.wiener(band, pilot, np.full((4, 3), 0.7, np.float32))
    np.testing.assert_allclose(np.stack(quads.to_complex(band)), gain * z, atol=1e-5)
    quads.scale(scaled, *gain.astype(np.float32))
    np.testing.assert_allclose(scaled, band, atol=1e-5)
    np.testing.assert_allclose(quads.magnitudes(pilot), np.abs(x), atol=1e-5)
    np.testing.assert_allclose(quads.to_real(*quads.to_complex(pilot)), pilot, atol=1e-6)


@pytest.mark.parametrize(
    ("first", "further"), [("near_sym_a", "qshift_06"), ("near_sym_b", "qshift_b")]
)
def test_noise_gains_are_those_of_white_noise(first, further):
    white = np.random.default_rng(0).normal(size=(512, 512)).astype(np.float32)
    bands = trees.analyse(white, 3, first, further)
    for detail, (side, diagonal) in zip(
        bands.details, trees.noise_gains(3, first, further), strict=True
    ):
        for band, gain in zip(detail, (side, side, diagonal), strict=True):
            assert np.std(band) == pytest.approx(gain, rel=0.03)


def test_noise_gains_of_an_orthonormal_wavelet_are_one():
    np.testing.assert_allclose(dwt.noise_gains(4, "db4"), 1.0, atol=1e-5)


@settings(max_examples=20, deadline=None)
@given(rows=st.integers(1, 9), cols=st.integers(1, 9), seed=st.integers(0, 2**32 - 1))
def test_banded_matrices_are_matrices(rows, cols, seed):
    rng = np.random.default_rng(seed)
    dense = (rng.normal(size=(rows, cols)) * (rng.random((rows, cols)) < 0.6)).astype(np.float32)
    r, c = np.nonzero(dense)
    matrix = banded.banded(r, c, dense[r, c], dense.shape)
    x = rng.normal(size=(cols, 7)).astype(np.float32)
    y = rng.normal(size=(rows, 7)).astype(np.float32)
    np.testing.assert_allclose(banded.apply(matrix, x), dense @ x, atol=1e-5)
    np.testing.assert_allclose(
        banded.apply(banded.adjoint(matrix, cols), y), dense.T @ y, atol=1e-5
    )
    np.testing.assert_array_equal(banded.transpose(x), x.T)


def test_per_pixel_sigma_smooths_most_where_the_noise_is():
    rng = np.random.default_rng(0)
    sigma = np.where(np.arange(50) < 25, 0.3, 5.0) * np.ones((80, 1))
    image = RangeImage(hill() + sigma * rng.normal(size=(80, 50)), CAMERA, sigma=sigma)
    local = denoise.dtcwt(image)
    uniform = denoise.dtcwt(image, per_pixel_sigma=False)
    quiet = np.s_[:, :20]
    assert np.std((local.depth - hill())[quiet]) < 0.3
    assert np.std((local.depth - hill())[quiet]) < 0.8 * np.std((uniform.depth - hill())[quiet])


def test_a_hole_beside_a_cliff_does_not_ring():
    """What surrounds a hole continues into it: no step, hence no oscillation beside it."""
    depth = hill()
    depth[30:50, 10:30] = np.nan
    image = RangeImage(depth, CAMERA, sigma=np.full(depth.shape, 1.0))
    out = denoise.dtcwt(image)
    assert np.nanmax(np.abs(out.depth - depth)) < 1.0


# ── normalized convolution ───────────────────────────────────────────────────────────────


def brute_force(values, confidence, variance, reference, step, kernel):
    """Eq. 3.6, pixel by pixel, in float64: the specification of the gated kernel."""
    rows, cols = values.shape
    radius = len(kernel) // 2
    mean, spread = np.full((2, rows, cols), np.nan)
    for y in range(rows):
        for x in range(cols):
            total = weight = squares = 0.0
            for v in range(max(0, y - radius), min(rows, y + radius + 1)):
                for u in range(max(0, x - radius), min(cols, x + radius + 1)):
                    if abs(values[v, u] - reference[y, x]) <= step[y, x]:
                        w = kernel[v - y + radius] * kernel[u - x + radius] * confidence[v, u]
                        weight, total = weight + w, total + w * values[v, u]
                        squares += w * w * variance[v, u]
            if weight > 0:
                mean[y, x], spread[y, x] = total / weight, squares / weight**2
    return mean, spread


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("shape", [(9, 14), (1, 5), (6, 2)])
def test_gated_convolution_is_its_specification(seed, shape):
    rng = np.random.default_rng(seed)
    z = rng.normal(500.0, 15.0, shape).astype(np.float32)
    z[rng.random(shape) < 0.2] = np.nan
    C, var, step = (rng.uniform(0.1, 20.0, shape).astype(np.float32) for _ in range(3))
    kernel = smoothing.gaussian_kernel(1.2)
    reference = np.where(np.isfinite(z), z, np.float32(500.0))
    mean, spread, _ = smoothing.gated_convolution(z, C, var, reference, step, kernel)
    want_mean, want_spread = brute_force(z, C, var, reference, step, kernel)
    np.testing.assert_allclose(mean, want_mean, rtol=1e-5)
    np.testing.assert_allclose(spread, want_spread, rtol=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_local_planes_are_weighted_least_squares(seed):
    rng = np.random.default_rng(seed)
    z = (500.0 + 3.0 * np.arange(12) + rng.normal(0.0, 4.0, (9, 12))).astype(np.float32)
    z[rng.random(z.shape) < 0.15] = np.nan
    trust = rng.uniform(0.5, 2.0, z.shape).astype(np.float32)
    kernel = smoothing.gaussian_kernel(1.0)
    out = smoothing.local_planes(z, trust, np.full_like(z, 15.0), kernel)
    v, u = np.mgrid[-3:4, -3:4]
    for y in range(3, 6):
        for x in range(3, 9):
            window = np.s_[y - 3 : y + 4, x - 3 : x + 4]
            near = np.abs(z[window] - z[y, x]) <= 15.0
            if np.isnan(z[y, x]) or near.sum() < 6:
                continue
            w = np.sqrt((np.outer(kernel, kernel) * trust[window])[near])
            A = np.stack([np.ones(near.sum()), u[near], v[near]], axis=1)
            plane, *_ = np.linalg.lstsq(w[:, None] * A, w * z[window][near], rcond=None)
            assert out[y, x] == pytest.approx(plane[0], abs=0.02)


def test_an_open_gate_gives_the_separable_convolution():
    rng = np.random.default_rng(0)
    z = rng.normal(0.0, 5.0, (20, 30)).astype(np.float32)
    C, var = rng.uniform(0.1, 2.0, (2, 20, 30)).astype(np.float32)
    kernel = smoothing.gaussian_kernel(1.0)
    wide = np.full_like(z, 1e6)
    gated = smoothing.gated_convolution(z, C, var, z, wide, kernel)
    separable = smoothing.normalized_convolution(z, C, var, kernel)
    for a, b in zip(gated, separable, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-4)


def test_with_full_confidence_inside_it_is_the_gaussian_blur():
    z = np.random.default_rng(0).normal(size=(30, 40)).astype(np.float32)
    one = np.ones_like(z)
    mean, _, _ = smoothing.normalized_convolution(z, one, None, smoothing.gaussian_kernel(1.0))
    blur = cv2.GaussianBlur(z, (7, 7), 1.0)
    np.testing.assert_allclose(mean[3:-3, 3:-3], blur[3:-3, 3:-3], atol=1e-5)


@pytest.mark.parametrize("max_step_mm", [20.0, None])
@pytest.mark.parametrize("seed", range(3))
def test_confidence_squared_amplitude_is_the_best_linear_weight(seed, max_step_mm):
    """σ ∝ 1/A, so A² weighs by 1/σ² (Gauss–Markov); the paper's inverse amplitude is worst."""
    rng = np.random.default_rng(seed)
    amplitude = rng.uniform(5.0, 100.0, (60, 60))
    sigma = 100.0 / amplitude
    camera = Orthographic(2.0, 30, 30, 60, 60)
    image = RangeImage(500.0 + sigma * rng.normal(size=(60, 60)), camera, sigma, amplitude)
    error = {
        c: np.std(
            denoise.normalized_convolution(image, confidence=c, max_step_mm=max_step_mm).depth
        )
        for c in ("amplitude_squared", "amplitude", "uniform", "inverse_amplitude")
    }
    assert sorted(error, key=error.get) == list(error)


@pytest.mark.parametrize(
    ("method", "tolerance"),
    [
        (denoise.normalized_convolution, 0.1),
        (lambda image: denoise.normalized_convolution(image, max_step_mm=None), 0.1),
        (denoise.moving_least_squares, 0.1),
        (denoise.median, 0.1),
        # the mean gain of a sub-band stands for that of its noise
        (lambda image: denoise.dtcwt(image, shrinkage="soft"), 0.5),
        (lambda image: denoise.dwt(image, shrinkage="soft"), 0.5),
        (denoise.auto, 0.5),
    ],
)
def test_sigma_after_a_smoother_is_what_is_left_of_the_noise(method, tolerance):
    """On a plane, where nothing but noise is smoothed."""
    noise_only = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    image = RangeImage(500.0 + noise_only, CAMERA, sigma=np.full((80, 50), 2.0))
    out = method(image)
    inner = np.s_[8:-8, 8:-8]
    assert np.median(out.sigma[inner]) == pytest.approx(np.std(out.depth[inner]), rel=tolerance)


def test_nothing_is_smeared_across_a_depth_discontinuity():
    depth = np.where(np.arange(50) < 25, 400.0, 900.0) * np.ones((80, 1))
    image = RangeImage(depth, CAMERA)
    for method in (denoise.normalized_convolution, denoise.moving_least_squares, denoise.median):
        np.testing.assert_allclose(method(image).depth, depth, atol=1e-3)


def test_holes_are_filled_from_their_own_surface_and_silhouettes_do_not_grow():
    depth = np.full((40, 40), np.nan)
    depth[10:30, 10:30] = 500.0
    depth[20, 20] = np.nan
    image = RangeImage(depth, Orthographic(2.0, 20, 20, 40, 40))
    out = denoise.normalized_convolution(image)
    assert np.argwhere(out.filled).tolist() == [[20, 20]]
    assert out.mask.sum() == image.mask.sum() + 1
    assert not denoise.normalized_convolution(image, fill=False).filled.any()


def test_flying_pixels_go_and_the_surfaces_stay():
    depth = np.where(np.arange(50) < 25, 400.0, 900.0) * np.ones((80, 1))
    depth[:, 25] = np.random.default_rng(0).uniform(500.0, 800.0, 80)
    out = denoise.flying_pixels(RangeImage(depth, CAMERA, sigma=np.full((80, 50), 1.0)))
    assert out.mask[:, 25].mean() < 0.1
    kept = np.delete(out.mask, [24, 25, 26], axis=1)
    assert kept[1:-1, 1:-1].all()


@settings(max_examples=20, deadline=None)
@given(rows=st.integers(1, 40), cols=st.integers(1, 40), seed=st.integers(0, 2**32 - 1))
def test_continuation_keeps_what_is_valid_and_stays_within_its_range(rows, cols, seed):
    rng = np.random.default_rng(seed)
    z = rng.normal(500.0, 10.0, (rows, cols)).astype(np.float32)
    valid = rng.random((rows, cols)) < 0.4
    valid[rng.integers(rows), rng.integers(cols)] = True
    hidden = np.where(valid, z, np.float32(np.nan))
    for continued in (holes.extended(hidden, valid), holes.nearest_valid(z, valid)):
        np.testing.assert_array_equal(continued[valid], z[valid])
        assert continued.min() >= z[valid].min() - 1e-3
        assert continued.max() <= z[valid].max() + 1e-3


@pytest.mark.parametrize("sigma", [0.5, 2.0, 10.0])
def test_sigma_is_estimated_through_slopes_and_holes(sigma):
    depth = hill() + np.random.default_rng(1).normal(0.0, sigma, (80, 50))
    depth[10:20] = np.nan
    assert noise.estimate_sigma(depth) == pytest.approx(sigma, rel=0.1)


def test_coarsely_rounded_depth_still_shows_its_noise():
    """Rounding to q adds q²/12; within a factor of two, where half of the details are zero."""
    v, u = np.mgrid[:80, :50]
    depth = 500.0 + 0.6 * u + 0.7 * v + np.random.default_rng(0).normal(0.0, 1.5, u.shape)
    rounded = np.round(depth / 8.0) * 8.0
    assert 0.5 < noise.estimate_sigma(rounded) / np.sqrt(1.5**2 + 64.0 / 12.0) < 2.0
    assert noise.estimate_sigma(np.full((9, 9), 7.0)) == 0.0
    assert np.isnan(noise.estimate_sigma(np.full((9, 9), np.nan)))


# ── moving heads ─────────────────────────────────────────────────────────────────────────


def sphere(T_camera_face, camera, rng, sigma):
    """A ball of 80 mm radius around a point of the face frame, seen exactly, plus noise."""
    centre = T_camera_face.apply([0.0, 0.0, 80.0])
    rays = camera.back_project(np.ones((camera.height, camera.width))).astype(np.float64)
    a = np.sum(rays**2, axis=-1)
    b = rays @ centre
    inside = b**2 - a * (centre @ centre - 80.0**2)
    z = np.where(inside > 0, (b - np.sqrt(np.maximum(inside, 0.0))) / a, np.nan)
    return RangeImage(
        z + rng.normal(0.0, sigma, z.shape), camera, sigma=np.full(z.shape, max(sigma, 1e-3))
    )


def test_motion_compensation_brings_a_moving_head_back():
    rng = np.random.default_rng(0)
    camera = Pinhole(200.0, 200.0, 39.5, 29.5, 80, 60)
    poses, frames = [], []
    for k in range(8):
        R = rotation_matrix([0.0, 0.02 * k, 0.01 * k])
        T = RigidTransform(R, [1.5 * k, -1.0 * k, 400.0 + 4.0 * k], "camera", "face")
        poses.append(T.inverse())
        frames.append(sphere(T, camera, rng, 1.0))
    truth = sphere(poses[0].inverse(), camera, rng, 0.0).depth
    moved = combine.motion_compensated_mean(frames, poses=poses)
    middle = np.s_[20:40, 25:55]
    error = (moved.depth - truth)[middle]
    assert np.abs(np.median(error)) < 0.2
    assert np.std(error) < 0.5
    blind = combine.mean(frames)
    assert np.abs(np.median((blind.depth - truth)[middle])) > 5.0


def test_the_recursive_filter_follows_a_jump_and_holds_through_a_gap():
    camera = Pinhole(200, 200, 0, 0, 1, 1)
    still = [RangeImage([[500.0]], camera, sigma=[[2.0]])] * 5
    jump = [RangeImage([[600.0]], camera, sigma=[[2.0]])]
    gap = [RangeImage([[np.nan]], camera, sigma=[[2.0]])]
    assert combine.recursive([*still, *jump]).depth[0, 0] == pytest.approx(600.0)
    held = combine.recursive([*still, *gap])
    assert held.depth[0, 0] == pytest.approx(500.0)
    assert held.filled[0, 0]
    assert combine.recursive(still * 20).sigma[0, 0] == pytest.approx(
        2.0 * np.sqrt(0.3 / (2.0 - 0.3)), rel=1e-3
    )


def test_space_time_convolution_smooths_along_both():
    rng = np.random.default_rng(0)
    frames = [
        RangeImage(hill() + rng.normal(0, 3.0, (80, 50)), CAMERA, sigma=np.full((80, 50), 3.0))
        for _ in range(5)
    ]
    space = denoise.normalized_convolution(frames[0])
    both = combine.space_time_convolution(frames)
    assert rmse(both) < 0.8 * rmse(space)
    assert (both.sigma < space.sigma).all()
