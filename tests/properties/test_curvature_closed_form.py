"""Curvature against surfaces whose curvature is known, and its σ against simulation."""

import numpy as np
import pytest

from rangeface.numerics import curvature

PITCH = 1.0


def grid(rows=31, columns=25):
    v, u = np.mgrid[0:rows, 0:columns].astype(float)
    return (u - columns // 2) * PITCH, (v - rows // 2) * PITCH


def surfaces():
    """Name, depth, K, H on a 1 mm grid; radii of the size of a face's parts."""
    x, y = grid()
    zero = np.zeros_like(x)
    yield "plane", 0.4 * x - 0.3 * y, zero, zero
    R = 60.0
    yield "sphere", R - np.sqrt(R**2 - x**2 - y**2), zero + R**-2, zero + 1 / R
    a = 120.0  # z = xy/a: p = y/a, q = x/a, s = 1/a
    g = 1 + (x**2 + y**2) / a**2
    yield "saddle", x * y / a, -1 / a**2 / g**2, -x * y / a**3 / g**1.5
    # torus: tube r around a circle of radius c; ψ is the angle on the tube
    c, r = 100.0, 70.0
    ring = np.hypot(x + c, y)
    z = r - np.sqrt(r**2 - (ring - c) ** 2)
    sine = (ring - c) / r
    yield "torus", z, sine / (r * (c + r * sine)), 0.5 * (1 / r + sine / (c + r * sine))


@pytest.mark.parametrize("surface", list(surfaces()), ids=lambda s: s[0])
@pytest.mark.parametrize("method", ["difference", "fit"])
def test_within_one_percent_of_closed_form(surface, method):
    _, z, K, H = surface
    z64 = z + 0.0
    if method == "difference":
        found = curvature.by_differences(z64, PITCH)
    else:
        found = curvature.by_fit(z64, PITCH, radius=2.9)
    inner = (slice(5, -5), slice(5, -5))
    scale = max(np.abs(H[inner]).max(), np.sqrt(np.abs(K[inner]).max()), 1e-3)
    np.testing.assert_allclose(found[1][inner], H[inner], rtol=0.01, atol=0.01 * scale)
    np.testing.assert_allclose(found[0][inner], K[inner], rtol=0.01, atol=0.01 * scale**2)


def test_measures_of_the_basic_shapes():
    """Koenderink and van Doorn: cap +1, ridge ½, saddle 0, rut −½, cup −1."""
    k1 = np.array([1.0, 1.0, 1.0, 0.0, -1.0])
    k2 = np.array([1.0, 0.0, -1.0, -1.0, -1.0])
    K, H = k1 * k2, (k1 + k2) / 2
    np.testing.assert_allclose(curvature.of_kind("shape_index", K, H), [1, 0.5, 0, -0.5, -1])
    np.testing.assert_allclose(curvature.of_kind("maximal", K, H), k1)
    np.testing.assert_allclose(curvature.of_kind("minimal", K, H), k2)
    curvedness = np.sqrt((k1**2 + k2**2) / 2)
    np.testing.assert_allclose(curvature.of_kind("curvedness", K, H), curvedness)


@pytest.mark.parametrize("kind", curvature.KINDS)
def test_sigma_is_that_of_repeated_noise(kind):
    x, y = grid(9, 9)
    z = 0.5 * (x**2 / 20 - y**2 / 50) + 0.1 * x  # far from umbilics: derivatives exist
    sigma = np.full(z.shape, 0.05)
    K, H, C = curvature.by_fit_with_sigma(z, PITCH, radius=4.0, sigma=sigma)
    predicted = curvature.sigma_of_kind(kind, K, H, C)[4, 4]
    noisy = z + np.random.default_rng(0).normal(size=(4000, 9, 9)) * sigma
    draws = curvature.of_kind(kind, *curvature.by_fit(noisy, PITCH, radius=4.0))[:, 4, 4]
    assert predicted == pytest.approx(draws.std(), rel=0.06)


def test_fit_is_far_less_noisy_than_differences():
    """Figure 5 of the paper, in numbers: noise of 0.5 mm on a sphere at 2 mm pitch."""
    rng = np.random.default_rng(1)
    x, y = grid(25, 25)
    z = 80 - np.sqrt(80**2 - (2 * x) ** 2 - (2 * y) ** 2) + rng.normal(0, 0.5, x.shape)
    inner = (slice(6, -6), slice(6, -6))
    rough = curvature.by_differences(z, 2.0)[1][inner].std()
    smooth = curvature.by_fit(z, 2.0, radius=10.0)[1][inner].std()
    assert rough > 25 * smooth


def test_batch_equals_loop():
    z = np.random.default_rng(0).normal(size=(3, 12, 12))
    for f in (
        lambda d: curvature.by_fit(d, 2.0, radius=5.0),
        lambda d: curvature.by_differences(d, 2.0),
    ):
        for many, one in zip(f(z), zip(*[f(d) for d in z], strict=True), strict=True):
            np.testing.assert_array_equal(many, np.stack(one))
