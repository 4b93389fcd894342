"""The local fit against NumPy's least squares, and its covariance against simulation."""

import numpy as np
import pytest

from rangeface.numerics import localfit


def reference(f, sigma, v, u, radius, degree):
    rows, right = [], []
    for j in range(-radius, radius + 1):
        for i in range(-radius, radius + 1):
            r, c = v + j, u + i
            inside = 0 <= r < f.shape[0] and 0 <= c < f.shape[1] and i * i + j * j <= radius**2
            if inside and np.isfinite(f[r, c]):
                basis = [1, i, j, i * i / 2, i * j, j * j / 2][: localfit.TERMS[degree]]
                rows.append(np.array(basis) / sigma[r, c])
                right.append(f[r, c] / sigma[r, c])
    return np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("weighted", [True, False])
def test_follows_numpy_least_squares(degree, weighted):
    rng = np.random.default_rng(3)
    f = rng.normal(size=(12, 15))
    f[4:6, 7] = np.nan
    sigma = rng.uniform(0.5, 2.0, f.shape) if weighted else np.ones(f.shape)
    given = sigma if weighted else None
    found = localfit.fit(f, sigma=given, radius_px=3, degree=degree)
    for v, u in [(0, 0), (5, 6), (6, 8), (11, 14), (3, 3), (4, 11), (8, 7)]:
        np.testing.assert_allclose(
            found[v, u], reference(f, sigma, v, u, 3, degree), rtol=1e-4, atol=1e-5
        )
    assert np.isnan(found[4, 7]).all()


def test_covariance_is_that_of_repeated_fits():
    rng = np.random.default_rng(4)
    sigma = rng.uniform(0.5, 2.0, (7, 7))
    noise = rng.normal(size=(20_000, 7, 7)) * sigma
    _, C = localfit.fit_with_covariance(noise[:1], sigma=sigma, radius_px=3)
    draws = localfit.fit(noise, sigma=sigma, radius_px=3)[:, 3, 3]
    expected = np.cov(draws.T)
    scale = np.sqrt(np.outer(expected.diagonal(), expected.diagonal()))
    assert np.abs(C[0, 3, 3] - expected).max() < 0.05 * scale.max()
    assert (np.abs(C[0, 3, 3] - expected) / scale).max() < 0.05


def test_batch_equals_loop():
    f = np.random.default_rng(1).normal(size=(3, 9, 9))
    np.testing.assert_array_equal(localfit.fit(f), np.stack([localfit.fit(g) for g in f]))


def test_undetermined_disc_is_nan():
    f = np.full((5, 5), np.nan)
    f[2] = 1.0  # a line determines no plane
    assert np.isnan(localfit.fit(f, degree=1)).all()
