"""Maps of the sphere, unwrapping, smoothing, histograms, HOG, Gabor, covariance."""

import numpy as np
import pytest

from rangeface import describe
from rangeface.errors import DegenerateError
from rangeface.numerics import gabor, gaussian, histograms, hog, phase, regions, sphere
from rangeface.types import Orthographic, RangeImage


def hemisphere(n=400, seed=0):
    N = np.random.default_rng(seed).normal(size=(n, 3))
    N[:, 2] = np.abs(N[:, 2])
    return N / np.linalg.norm(N, axis=1, keepdims=True)


def jacobians(f, N, h=2e-3):
    """Singular values of a map of the sphere into the plane, by differences."""
    e1 = np.cross(N, [0.0, 0.0, 1.0])
    e1 /= np.linalg.norm(e1, axis=1, keepdims=True)
    e2 = np.cross(N, e1)
    columns = []
    for e in (e1, e2):
        ahead, behind = (np.cos(h) * N + s * np.sin(h) * e for s in (1, -1))
        columns.append((f(ahead).astype(float) - f(behind)) / (2 * h))
    return np.linalg.svd(np.stack(columns, -1), compute_uv=False)


def test_stereographic_is_conformal():
    s = jacobians(sphere.stereographic, hemisphere())
    np.testing.assert_allclose(s[:, 0], s[:, 1], rtol=3e-3)


def test_lambert_keeps_areas():
    s = jacobians(sphere.lambert, hemisphere())
    np.testing.assert_allclose(s.prod(axis=1), 1.0, rtol=3e-3)


def test_log_map_keeps_the_distance_to_its_base():
    N = hemisphere()
    base = np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9])
    distance = np.linalg.norm(sphere.log_map(N, base), axis=1)
    np.testing.assert_allclose(distance, np.arccos(np.clip(N @ base, -1, 1)), atol=1e-5)


def test_unwrapping_recovers_a_surface_without_singularities():
    v, u = np.mgrid[0:40, 0:30]
    truth = 0.02 * (v - 18) ** 2 + 0.3 * u
    weight = np.ones(truth.shape)
    weight[5:9, 5:9] = 0.0
    found = phase.unwrap(phase.wrap(truth), weight, tolerance=1e-8, max_iterations=200)
    error = (found - truth)[weight > 0]
    assert np.ptp(error) < 1e-3
    assert abs(phase.wrap(error.mean())) < 1e-3


def test_unwrapped_angle_has_no_jumps_of_two_pi():
    v, u = np.mgrid[0:40, 0:30]
    image = RangeImage(0.05 * (u - 15) ** 2 + 1.5 * (v - 20), Orthographic(2.0, 15, 20, 30, 40))
    wrapped = describe.normal_angle(image, unwrapped=False)
    smooth = describe.normal_angle(image)
    assert np.abs(np.diff(smooth, axis=1)).max() < 1.0
    turned = phase.wrap(smooth - wrapped - (smooth - wrapped)[20, 15])
    np.testing.assert_allclose(turned, 0.0, atol=0.05)
    assert abs(smooth.mean()) < 0.1


def test_smoothing_follows_the_definition():
    rng = np.random.default_rng(0)
    f = rng.normal(size=(12, 9)).astype(np.float32)
    f[rng.random(f.shape) < 0.2] = np.nan
    v, u = np.mgrid[0:12, 0:9]
    found = gaussian.smooth(f, 0.8)
    assert (np.isnan(found) == np.isnan(f)).all()
    for r, c in np.argwhere(np.isfinite(f)):
        near = (np.abs(v - r) <= 3) & (np.abs(u - c) <= 3) & np.isfinite(f)
        w = np.exp(-((v - r) ** 2 + (u - c) ** 2) / (2 * 0.8**2))[near]
        assert found[r, c] == pytest.approx((w * f[near]).sum() / w.sum(), abs=1e-5)
    batch = np.stack([f, f[::-1]])
    loop = np.stack([gaussian.smooth(g, 0.8) for g in batch])
    np.testing.assert_array_equal(gaussian.smooth(batch, 0.8), loop)


def test_histograms_count_only_what_is_valid():
    labels = np.array([[0, 1, 2, 2], [0, 1, 1, 1]])
    valid = np.array([[1, 1, 0, 0], [1, 0, 0, 0]], bool)
    found = histograms.regional(labels, valid, count=3, regions=(1, 2)).reshape(2, 3)
    np.testing.assert_allclose(found[0], [2 / 3, 1 / 3, 0], atol=1e-6)
    np.testing.assert_allclose(found[1], found[0])  # an empty region: the whole face


def test_hog_is_blind_to_the_sign_and_size_of_a_gradient():
    rng = np.random.default_rng(0)
    gx, gy = rng.normal(size=(2, 16, 16))
    np.testing.assert_allclose(hog.hog(gx, gy), hog.hog(-gx, -gy), atol=1e-6)
    np.testing.assert_allclose(hog.hog(gx, gy), hog.hog(5 * gx, 5 * gy), atol=1e-3)


def test_hog_votes_are_shared_between_orientations():
    angle = np.deg2rad(30.0)  # between 20° and 40° of nine bins
    gx, gy = np.full((8, 8), np.cos(angle)), np.full((8, 8), np.sin(angle))
    found = hog.hog(gx, gy, block_cells=1)
    np.testing.assert_allclose(found[[1, 2]], np.sqrt(0.5), atol=1e-3)


def test_gabor_answers_to_its_own_wave():
    v, u = np.mgrid[0:64, 0:64]
    for scale in range(3):
        for direction in range(4):
            k, a = 0.5 * np.pi * 2 ** (-scale / 2), np.pi * direction / 4
            wave = np.cos(k * (np.cos(a) * u + np.sin(a) * v))
            response = gabor.magnitudes(wave)[32, 32]
            assert response.argmax() == 4 * scale + direction
            assert response.max() == pytest.approx(0.5, rel=0.05)


def test_gabor_batch_equals_loop():
    f = np.random.default_rng(0).normal(size=(3, 16, 12))
    loop = np.stack([gabor.magnitudes(g) for g in f])
    np.testing.assert_array_equal(gabor.magnitudes(f), loop)


def test_block_covariance_is_the_matrix_logarithm():
    rng = np.random.default_rng(0)
    f = rng.normal(size=(10, 8, 3))
    found = regions.block_covariance(f, blocks=(1, 1), regularisation=1e-3)
    C = np.cov(f.reshape(-1, 3).T) + 1e-3 * np.eye(3)
    values, vectors = np.linalg.eigh(C)
    L = vectors @ np.diag(np.log(values)) @ vectors.T
    assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(L), rel=1e-5)


def test_block_of_holes_has_the_mean_of_the_others():
    f = np.random.default_rng(0).normal(size=(12, 12, 2))
    f[:6, :6] = np.nan
    blocks = regions.block_covariance(f, blocks=(2, 2)).reshape(4, -1)
    np.testing.assert_allclose(blocks[0], blocks[1:].mean(axis=0), rtol=1e-4, atol=1e-5)
    with pytest.raises(DegenerateError):
        regions.block_covariance(f * np.nan, blocks=(2, 2))


def test_albedo_undoes_distance_and_slope():
    """A Lambertian surface of one albedo gives a constant, whatever its shape."""
    camera = Orthographic(2.0, 15, 20, 31, 41)
    y, x = np.mgrid[-20:21, -15:16] * 2.0
    z = 0.01 * x**2 + 0.006 * y**2
    cosine = 1 / np.sqrt(1 + (0.02 * x) ** 2 + (0.012 * y) ** 2)
    light = 3e7 * cosine / (x**2 + y**2 + (z + 600) ** 2)
    image = RangeImage(z, camera, amplitude=light)
    found = describe.albedo(image, distance_mm=600)[3:-3, 3:-3]
    assert np.abs(found).max() < 2e-3
