"""A z-buffer samples planar triangles exactly, in both projections."""

import numpy as np
import pytest

from rangeface.numerics.zbuffer import rasterise

PINHOLE = {
    "focal_px": (210.0, 190.0),
    "centre_px": (40.3, 29.7),
    "size_px": (80, 60),
    "perspective": True,
}
PARALLEL = {
    "focal_px": (0.5, 0.5),
    "centre_px": (40.3, 29.7),
    "size_px": (80, 60),
    "perspective": False,
}


def _rays(camera):
    u, v = np.meshgrid(np.arange(80.0), np.arange(60.0))
    x = (u - camera["centre_px"][0]) / camera["focal_px"][0]
    y = (v - camera["centre_px"][1]) / camera["focal_px"][1]
    return x, y


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("camera", [PINHOLE, PARALLEL], ids=["pinhole", "parallel"])
def test_a_tilted_plane_is_exact(camera, seed):
    rng = np.random.default_rng(seed)
    slope = rng.uniform(-0.8, 0.8, 2)
    xy = np.array([[-400.0, -400.0], [400.0, -400.0], [400.0, 400.0], [-400.0, 400.0]])
    plane = np.column_stack([xy, 900.0 + xy @ slope])
    depth, normal, triangle = rasterise(plane, [[0, 1, 2], [0, 2, 3]], **camera)
    x, y = _rays(camera)
    if camera["perspective"]:
        expected = 900.0 / (1.0 - slope[0] * x - slope[1] * y)
    else:
        expected = 900.0 + slope[0] * x + slope[1] * y
    seen = triangle >= 0
    assert seen.sum() > 1000
    np.testing.assert_allclose(depth[seen], expected[seen], atol=1e-3)
    n = np.array([slope[0], slope[1], -1.0]) / np.sqrt(1.0 + slope @ slope)
    np.testing.assert_allclose(normal[seen], np.broadcast_to(n, (seen.sum(), 3)), atol=1e-6)


@pytest.mark.parametrize("camera", [PINHOLE, PARALLEL], ids=["pinhole", "parallel"])
def test_a_sphere_is_within_a_hundredth_of_a_mm_inside_its_silhouette(camera):
    radius, centre = 50.0, np.array([3.0, -2.0, 500.0])
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 500), np.linspace(0, 2 * np.pi, 1000))
    unit = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )
    first = (np.arange(999)[:, None] * 500 + np.arange(499)).ravel()
    quads = [[first, first + 1, first + 500], [first + 1, first + 501, first + 500]]
    triangles = np.concatenate([np.stack(q, axis=-1) for q in quads])
    depth, _, _ = rasterise((centre + radius * unit).reshape(-1, 3), triangles, **camera)
    x, y = _rays(camera)
    if camera["perspective"]:
        ray = np.stack([x, y, np.ones_like(x)], axis=-1)
        a, b = (ray**2).sum(-1), ray @ centre
        root = b**2 - a * (centre @ centre - radius**2)
        expected = (b - np.sqrt(np.maximum(root, 0))) / a
        closest = np.linalg.norm(centre - ray * (b / a)[..., None], axis=-1)
    else:
        closest = np.hypot(x - centre[0], y - centre[1])
        expected = centre[2] - np.sqrt(np.maximum(radius**2 - closest**2, 0))
    inside = closest < 0.95 * radius
    assert inside.sum() > 300
    assert np.abs(depth - expected)[inside].max() < 0.01


def test_the_nearest_surface_wins_whatever_the_order():
    near, far = 100.0, 200.0
    xy = np.array([[-500.0, -500.0], [500.0, -500.0], [0.0, 500.0]])
    points = np.concatenate([np.column_stack([xy, np.full(3, z)]) for z in (far, near)])
    for triangles in ([[0, 1, 2], [3, 4, 5]], [[3, 4, 5], [0, 1, 2]]):
        depth, _, _ = rasterise(points, triangles, **PINHOLE)
        assert np.nanmax(depth) == pytest.approx(near)


def test_a_triangle_behind_the_camera_is_left_out():
    points = [[-9.0, -9.0, -5.0], [9.0, -9.0, 5.0], [0.0, 9.0, 5.0]]
    depth, _, triangle = rasterise(points, [[0, 1, 2]], **PINHOLE)
    assert np.isnan(depth).all()
    assert (triangle == -1).all()


def test_subpixel_shift_moves_the_samples_not_the_surface():
    xy = np.array([[-400.0, -400.0], [400.0, -400.0], [0.0, 400.0]])
    plane = np.column_stack([xy, 900.0 + 0.5 * xy[:, 0]])
    whole, _, _ = rasterise(plane, [[0, 1, 2]], **PARALLEL)
    half, _, _ = rasterise(plane, [[0, 1, 2]], **(PARALLEL | {"centre_px": (39.8, 29.7)}))
    np.testing.assert_allclose((half - whole)[25:35, 30:50], 0.5, atol=1e-4)
