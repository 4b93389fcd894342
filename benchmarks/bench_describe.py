"""Features: local binary patterns, normals, profiles, and the rest, beside their peers."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from rangeface import describe
from rangeface.numerics import normals, patterns
from rangeface.types import Orthographic, RangeImage

Arms = dict[str, Callable[[], object]]


def stages() -> Iterator[tuple[str, str, Arms]]:
    """Yield (stage, size, {arm: callable}); peers that are not installed are left out."""
    image = frontal()
    relief = -image.depth
    grey = describe.depth_levels(image).astype(np.uint8)
    yield "LBP8,1 riu2", "80×50", {"ours": lambda: patterns.lbp(relief), **_scikit_lbp([grey])}
    batch = relief + np.random.default_rng(0).normal(0, 0.2, (1000, 1, 1)).astype(np.float32)
    yield (
        "LBP8,1 riu2, batch",
        "1000×80×50",
        {"ours": lambda: patterns.lbp(batch), **_scikit_lbp([grey] * 1000)},
    )
    yield (
        "LBP + 3DLBP 1–4",
        "80×50",
        {
            "ours": lambda: patterns.lbp_and_tdlbp(relief, unit=0.55),
            "numpy": lambda: _numpy_patterns(relief, 0.55),
        },
    )
    for size, (height, width) in {"176×144": (144, 176), "640×480": (480, 640)}.items():
        yield "back-projection + normals", size, _normal_arms(height, width)
    yield "profiles of a face (4)", "80×50", {"ours": lambda: describe.profiles(image)}
    for name, method in describe.METHODS.items():
        yield f"describe.{name}", "80×50", {"ours": lambda method=method: method(image)}  # type: ignore[misc]


def frontal() -> RangeImage:
    """A bumpy ellipsoid on the frontal grid of 80 × 50 pixels."""
    camera = Orthographic(2.8, 24.5, 42.0, 50, 80)
    v, u = np.mgrid[0:80, 0:50]
    x, y = (u - camera.cx) * 2.8 - 2.0, (v - camera.cy) * 2.8  # not quite centred
    inside = np.maximum(1.0 - (x / 90.0) ** 2 - (y / 140.0) ** 2, 0.0)
    depth = 110.0 - 92.0 * np.sqrt(inside) - 18.0 * np.exp(-(x**2 + y**2) / 300.0)
    depth += np.random.default_rng(1).normal(0.0, 0.5, depth.shape)
    return RangeImage(depth, camera, amplitude=np.full(depth.shape, 100.0))


def _scikit_lbp(images: list[np.ndarray]) -> Arms:
    try:
        from skimage.feature import local_binary_pattern
    except ImportError:
        print("scikit-image is not installed: its arm is left out")
        return {}
    return {"scikit-image": lambda: [local_binary_pattern(i, 8, 1, "uniform") for i in images]}


_UNIFORM = np.array(
    [
        bin(c).count("1") if bin(c ^ ((c >> 1) | (c & 1) << 7)).count("1") <= 2 else 9
        for c in range(256)
    ],
    np.float32,
)


def _numpy_patterns(f: np.ndarray, unit: float) -> object:
    """riu2 and the four layers with whole arrays, on the interior."""
    centre = f[1:-1, 1:-1]
    height, width = f.shape
    s = np.float32(np.sqrt(0.5))

    def at(dy: int, dx: int) -> np.ndarray:
        return f[1 + dy : height - 1 + dy, 1 + dx : width - 1 + dx] - centre

    east, south, west, north = at(0, 1), at(1, 0), at(0, -1), at(-1, 0)

    def corner(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
        return s * (1 - s) * (a + b) + s * s * c

    d = np.stack(
        [
            east,
            corner(east, south, at(1, 1)),
            south,
            corner(south, west, at(1, -1)),
            west,
            corner(west, north, at(-1, -1)),
            north,
            corner(north, east, at(-1, 1)),
        ]
    )
    weights = (1 << np.arange(8)).astype(np.uint8)[:, None, None]
    sign = d >= 0
    size = np.minimum(np.abs(d) * np.float32(1 / unit) + np.float32(0.5), 7).astype(np.uint8)
    code = (sign * weights).sum(axis=0, dtype=np.uint8)
    layers = [(((size >> b) & 1) * weights).sum(axis=0, dtype=np.uint8) for b in (2, 1, 0)]
    return _UNIFORM[code], code, layers


def _normal_arms(height: int, width: int) -> Arms:
    fx, cx, cy = 1.3 * width, width / 2, height / 2
    rng = np.random.default_rng(0)
    z = (400 + np.cumsum(rng.normal(0, 0.2, (height, width)), axis=1)).astype(np.float32)
    arms: Arms = {"ours": lambda: normals.from_depth_pinhole(z, fx, fx, cx, cy)}
    a = np.broadcast_to(((np.arange(width) - cx) / fx).astype(np.float32), z.shape).copy()
    b = np.repeat(((np.arange(height) - cy) / fx).astype(np.float32)[:, None], width, axis=1)
    kernel = np.array([[-1.0, 0.0, 1.0]], np.float32)

    def numpy_normals() -> object:
        p = np.stack([z * a, z * b, z], axis=-1)
        du, dv = p[1:-1, 2:] - p[1:-1, :-2], p[2:, 1:-1] - p[:-2, 1:-1]
        n = np.cross(dv, du)
        return n / np.linalg.norm(n, axis=-1, keepdims=True)

    arms["numpy"] = numpy_normals
    try:
        import cv2
    except ImportError:
        print("OpenCV is not installed: its arm is left out")
        return arms

    def opencv_normals() -> object:
        """Planes by cv2's vectorised arithmetic: derivative filters, products, normalisation."""
        x, y = cv2.multiply(z, a), cv2.multiply(z, b)
        xu, yu, zu = (cv2.filter2D(f, cv2.CV_32F, kernel) for f in (x, y, z))
        xv, yv, zv = (cv2.filter2D(f, cv2.CV_32F, kernel.T) for f in (x, y, z))
        nx = cv2.subtract(cv2.multiply(yv, zu), cv2.multiply(zv, yu))
        ny = cv2.subtract(cv2.multiply(zv, xu), cv2.multiply(xv, zu))
        nz = cv2.subtract(cv2.multiply(xv, yu), cv2.multiply(yv, xu))
        length = cv2.magnitude(cv2.magnitude(nx, ny), nz)
        return cv2.merge([cv2.divide(c, length) for c in (nx, ny, nz)])

    arms["OpenCV"] = opencv_normals
    return arms
