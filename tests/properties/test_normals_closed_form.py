"""Normals against surfaces whose normals are known, and against their definition."""

import numpy as np
import pytest

from rangeface.numerics import normals


def reference(points):
    """The definition, pixel by pixel: cross product of NaN-aware central differences."""
    height, width, _ = points.shape
    out = np.full(points.shape, np.nan)
    for v in range(height):
        for u in range(width):
            here = points[v, u]

            def at(dv, du, v=v, u=u, here=here):
                r, c = v + dv, u + du
                inside = 0 <= r < height and 0 <= c < width
                return points[r, c] if inside and np.isfinite(points[r, c, 2]) else here

            n = np.cross(at(1, 0) - at(-1, 0), at(0, 1) - at(0, -1))
            if np.isfinite(here[2]) and n.any():
                out[v, u] = n / np.linalg.norm(n)
    return out


@pytest.fixture
def depth():
    rng = np.random.default_rng(5)
    z = 400.0 + np.cumsum(rng.normal(size=(17, 23)), axis=0)
    z[rng.random(z.shape) < 0.2] = np.nan
    return z.astype(np.float32)


def test_points_pinhole_and_orthographic_follow_the_definition(depth):
    v, u = np.mgrid[0:17, 0:23]
    pinhole = np.stack([(u - 11) / 60.0 * depth, (v - 8) / 70.0 * depth, depth], -1)
    parallel = np.stack([u * 2.0 + 0 * depth, v * 2.0 + 0 * depth, depth], -1)
    for found, points in [
        (normals.from_points(pinhole), pinhole),
        (normals.from_depth_pinhole(depth, 60, 70, 11, 8), pinhole),
        (normals.from_points(parallel), parallel),
        (normals.from_depth_orthographic(depth, 2.0), parallel),
    ]:
        np.testing.assert_allclose(found, reference(points), atol=2e-3)


def angle_deg(a, b):
    return np.rad2deg(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


PITCH = 2.0


def surfaces():
    """Depth (mm), slopes and validity of closed-form surfaces on a 2 mm grid."""
    v, u = np.mgrid[-30:31, -20:21].astype(float)
    x, y = u * PITCH, v * PITCH
    yield "plane", 0.3 * x - 0.5 * y, 0.3 + 0 * x, -0.5 + 0 * x
    root = np.sqrt(110.0**2 - x**2 - y**2)
    yield "sphere", 110.0 - root, x / root, y / root
    yield "saddle", x * y / 150.0, y / 150.0, x / 150.0
    # a torus seen from above: tube 90 mm around a circle of 120 mm, its crest at x = 120
    ring = np.hypot(x + 120.0, y)
    crest = np.sqrt(90.0**2 - (ring - 120.0) ** 2)
    slope = (ring - 120.0) / crest / ring
    yield "torus", 90.0 - crest, slope * (x + 120.0), slope * y


@pytest.mark.parametrize("surface", list(surfaces()), ids=lambda s: s[0])
@pytest.mark.parametrize("method", ["difference", "plane", "quadric"])
def test_within_a_twentieth_of_a_degree_of_closed_form(surface, method):
    _, z, p, q = surface
    expected = normals.from_slopes(p, q)
    if method == "difference":
        found = normals.from_depth_orthographic(z, PITCH)
    else:
        degree = 1 if method == "plane" else 2
        found = normals.fit_orthographic(z, PITCH, radius_px=1 + degree // 2, degree=degree)
    inner = (slice(3, -3), slice(3, -3))
    assert angle_deg(found, expected)[inner].max() < 0.05


def test_pinhole_fit_is_exact_on_planes():
    v, u = np.mgrid[0:20, 0:30]
    a, b = (u - 14.0) / 50.0, (v - 9.0) / 50.0
    n = np.array([0.3, -0.4, -1.0]) / np.linalg.norm([0.3, -0.4, -1.0])
    z = -400.0 / (n[0] * a + n[1] * b + n[2])
    for found in (
        normals.from_depth_pinhole(z, 50, 50, 14, 9),
        normals.fit_pinhole(z, 50, 50, 14, 9, radius_px=2),
    ):
        assert angle_deg(found, n).max() < 0.05


def test_normals_face_the_camera():
    z = 500.0 + np.random.default_rng(0).normal(size=(20, 20))
    assert (normals.from_depth_orthographic(z, 2.0)[..., 2] < 0).all()


def test_batch_equals_loop(depth):
    batch = np.stack([depth, depth[::-1], depth + 3])
    for f in (
        lambda z: normals.from_depth_orthographic(z, 2.0),
        lambda z: normals.from_depth_pinhole(z, 60, 70, 11, 8),
        lambda z: normals.fit_orthographic(z, 2.0),
        lambda z: normals.fit_pinhole(z, 60, 70, 11, 8),
    ):
        np.testing.assert_array_equal(f(batch), np.stack([f(z) for z in batch]))


def test_covariance_of_the_normal_matches_simulation():
    rng = np.random.default_rng(2)
    p, q = 0.4, -0.7
    S = np.array([[4.0, 1.0], [1.0, 2.0]]) * 1e-4
    draws = rng.multivariate_normal([p, q], S, size=200_000)
    found = np.cov(normals.from_slopes(draws[:, 0], draws[:, 1]).T)
    np.testing.assert_allclose(normals.covariance_of_slopes(p, q, S), found, atol=3e-6)
