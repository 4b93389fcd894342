"""Simulation: noise of the paper's model, buckets, rendering and whole captures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.util import find_spec

import numpy as np

from rangeface import sensors, simulate
from rangeface.numerics import draws, zbuffer

Arms = dict[str, Callable[[], object]]

SIZES = {"176×144": (144, 176), "640×480": (480, 640)}
SCALE = np.float32(7494.8 / (2 * np.pi))  # mm per rad at 20 MHz


def stages() -> Iterator[tuple[str, str, Arms]]:
    """Yield (stage, size, {arm: callable}); peers that are not installed are left out."""
    for size, shape in SIZES.items():
        rng = np.random.default_rng(0)
        depth = rng.uniform(380, 480, shape).astype(np.float32)
        amplitude = rng.uniform(40, 300, shape).astype(np.float32)
        yield (
            "TOF noise (paper)",
            size,
            {
                "ours": lambda d=depth, a=amplitude, r=rng: (
                    d + SCALE * draws.angle_noise(a, rng=r)[0]
                ),
                "numpy": lambda d=depth, a=amplitude, r=rng: _numpy_noise(d, a, r),
                **_torch_noise(depth, amplitude),
            },
        )
        mean = rng.uniform(5e3, 2e5, (4, *shape)).astype(np.float32)
        yield (
            "TOF noise (four Poisson buckets)",
            size,
            {
                "ours": lambda m=mean, r=rng: draws.poisson(m, rng=r),
                "numpy": lambda m=mean, r=rng: r.poisson(m),
            },
        )
    yield from _faces()


def _faces() -> Iterator[tuple[str, str, Arms]]:
    sensor, rng = sensors.preset("sr3000"), np.random.default_rng(0)
    person, away = simulate.head(0), simulate.pose()
    points = away.apply(person.surface.points)
    camera, triangles = sensor.camera, person.surface.triangles
    options = {
        "focal_px": (camera.fx, camera.fy), "centre_px": (camera.cx, camera.cy),
        "size_px": (camera.width, camera.height), "perspective": True,
    }  # fmt: skip
    yield (
        f"z-buffer, {len(triangles)} triangles",
        "176×144",
        {
            "ours": lambda: zbuffer.rasterise(points, triangles, **options),
            **_open3d(points, triangles, camera),
        },
    )
    yield (
        "render, 3 × 3 samples a pixel",
        "176×144",
        {"ours": lambda: simulate.render(person, camera, away, oversample=3)},
    )
    scene = simulate.render(person, camera, away, oversample=3)
    yield "tof, every effect", "176×144", {"ours": lambda: simulate.tof(scene, sensor, rng=rng)}
    yield (
        "head, neutral to laugh",
        "29k triangles",
        {"ours": lambda: simulate.head(0, expression="laugh")},
    )
    yield (
        "collection, 2 people × 9 views",
        "176×144",
        {"ours": lambda: list(simulate.collection([0, 1], sensor, workers=2))},
    )


def _numpy_noise(depth, amplitude, rng):
    n1, n2 = (rng.standard_normal(depth.shape, np.float32) for _ in range(2))
    return depth + SCALE * np.arctan2(n2, amplitude + n1)


def _torch_noise(depth, amplitude) -> Arms:
    if find_spec("torch") is None:
        print("torch is not installed: left out")
        return {}
    import torch

    torch.set_num_threads(1)
    d, a = torch.from_numpy(depth), torch.from_numpy(amplitude)
    return {
        "torch": lambda: (
            d + float(SCALE) * torch.atan2(torch.randn_like(a), a + torch.randn_like(a))
        )
    }


def _open3d(points, triangles, camera) -> Arms:
    if find_spec("open3d") is None:
        print("open3d is not installed: left out")
        return {}
    import open3d as o3d

    mesh = o3d.t.geometry.TriangleMesh(
        o3d.core.Tensor(points.astype(np.float32)), o3d.core.Tensor(triangles.astype(np.int32))
    )
    K = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])

    def cast():
        scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        scene.add_triangles(mesh)
        rays = scene.create_rays_pinhole(K, np.eye(4), camera.width, camera.height)
        return scene.cast_rays(rays)["t_hit"].numpy()

    return {"Open3D ray casting": cast}
