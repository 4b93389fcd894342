"""Denoising: wavelets, normalized convolution and the rest, beside their peers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import cycle

import cv2
import numpy as np
import pywt

from rangeface import denoise
from rangeface.denoise import combine
from rangeface.numerics import dwt, smoothing
from rangeface.numerics.dtcwt import quads, trees
from rangeface.types import Pinhole, RangeImage

Arms = dict[str, Callable[[], object]]

SIZES = {"176×144": (144, 176), "640×480": (480, 640)}
LEVELS, FRAMES, T = 4, 8, 6.0


def stages() -> Iterator[tuple[str, str, Arms]]:
    """Yield (stage, size, {arm: callable}); peers that are not installed are left out."""
    for size, shape in SIZES.items():
        images = [scene(shape, seed) for seed in range(FRAMES)]
        holed = [image.depth - np.float32(500.0) for image in images]
        planes = [np.nan_to_num(plane) for plane in holed]
        yield (
            "DT-CWT denoise",
            size,
            {"ours": _rotating(_dual_tree, planes), **_dtcwt_library(planes)},
        )
        yield (
            "DWT denoise (db4)",
            size,
            {"ours": _rotating(_wavelets, planes), "PyWavelets": _rotating(_pywavelets, planes)},
        )
        yield (
            "normalized convolution",
            size,
            {
                "ours": _rotating(_normalized, holed),
                "OpenCV, two blurs": _rotating(_two_blurs, holed),
            },
        )
        for name, method in _variants().items():
            yield f"denoise.{name}", size, {"ours": _rotating(method, images)}
        yield "combine.mean, 10 frames", size, {"ours": lambda f=images: combine.mean(f + f[:2])}
        yield (
            "combine.phasor_mean, 10 frames",
            size,
            {"ours": lambda f=images: combine.phasor_mean(f + f[:2])},
        )


def scene(shape: tuple[int, int], seed: int) -> RangeImage:
    """A sphere before a wall, 3 mm of noise, its amplitude and σ, and 2 % of holes."""
    rng = np.random.default_rng(seed)
    rows, cols = shape
    v, u = np.mgrid[:rows, :cols]
    r2 = ((u - cols / 2) / cols) ** 2 + ((v - rows / 2) / rows) ** 2
    amplitude = 100.0 * (1.0 - r2)
    sigma = 300.0 / amplitude
    depth = np.where(r2 < 0.15, 400.0 + 300.0 * r2, 700.0) + sigma * rng.normal(size=shape)
    camera = Pinhole(cols, cols, cols / 2, rows / 2, cols, rows)
    holes = rng.random(shape) < 0.02
    return RangeImage(depth, camera, sigma, amplitude).masked(~holes)


def _rotating(f: Callable[[object], object], inputs: list) -> Callable[[], object]:
    """Another frame at every call, so that no arm lives on a warm cache."""
    turn = cycle(inputs)
    return lambda: f(next(turn))


def _variants() -> dict[str, Callable[[RangeImage], RangeImage]]:
    """Whole methods: masked, with per-pixel σ, filling and propagation of σ."""
    return {
        "auto": denoise.auto,
        "dtcwt(soft), masked, per-pixel σ": lambda i: denoise.dtcwt(i, shrinkage="soft"),
        "dtcwt(bivariate), masked, per-pixel σ": lambda i: denoise.dtcwt(i, shrinkage="bivariate"),
        "dwt(soft), masked, per-pixel σ": denoise.dwt,
        "normalized_convolution, gated, σ": denoise.normalized_convolution,
        "normalized_convolution, open, σ": lambda i: denoise.normalized_convolution(
            i, max_step_mm=None
        ),
        **{
            name: denoise.METHODS[name]
            for name in ("median", "bilateral", "guided", "moving_least_squares", "flying_pixels")
        },
    }


# ── arms: the same work on a plane without holes ─────────────────────────────────────────


def _dual_tree(plane: np.ndarray) -> np.ndarray:
    bands = trees.analyse(plane, LEVELS, "near_sym_a", "qshift_a")
    for detail in bands.details:
        for band in detail:
            quads.soft(band, _threshold(band.shape[0] // 2, band.shape[1] // 2))
    return trees.synthesise(bands)


@lru_cache
def _threshold(rows: int, cols: int) -> np.ndarray:
    """One T for all, which the peers take as a scalar."""
    return np.full((rows, cols), T, dtype=np.float32)


def _dtcwt_library(planes: list[np.ndarray]) -> Arms:
    # the library was written for numpy 1
    np.__dict__.setdefault("asfarray", lambda a, dtype=np.float64: np.asarray(a, dtype=dtype))
    np.__dict__.setdefault("issubsctype", np.issubdtype)
    try:
        import dtcwt
    except ImportError:
        print("dtcwt is not installed: its arm is left out")
        return {}
    transform = dtcwt.Transform2d(biort="near_sym_a", qshift="qshift_a")

    def run(plane: np.ndarray) -> np.ndarray:
        pyramid = transform.forward(plane, nlevels=LEVELS)
        for w in pyramid.highpasses:
            magnitude = np.abs(w)
            w *= np.maximum(magnitude - T, 0.0) / np.maximum(magnitude, 1e-30)
        return transform.inverse(pyramid)

    return {"dtcwt": _rotating(run, planes)}


def _wavelets(plane: np.ndarray) -> np.ndarray:
    bands = dwt.forward(plane, wavelet="db4", levels=LEVELS)
    for detail in bands.details:
        for band in detail:
            dwt.soft(band, _threshold(*band.shape))
    return dwt.inverse(bands)


def _pywavelets(plane: np.ndarray) -> np.ndarray:
    lowpass, *details = pywt.wavedec2(plane, "db4", mode="symmetric", level=LEVELS)
    soft = [tuple(pywt.threshold(band, T, "soft") for band in detail) for detail in details]
    return pywt.waverec2([lowpass, *soft], "db4", mode="symmetric")


_KERNEL = smoothing.gaussian_kernel(1.0)


def _normalized(plane: np.ndarray) -> np.ndarray:
    confidence = np.isfinite(plane).astype(np.float32)
    return smoothing.normalized_convolution(plane, confidence, None, _KERNEL)[0]


def _two_blurs(plane: np.ndarray) -> np.ndarray:
    confidence = np.isfinite(plane).astype(np.float32)
    values = np.where(confidence > 0, plane, np.float32(0))
    size = (len(_KERNEL), len(_KERNEL))
    top = cv2.GaussianBlur(values * confidence, size, 1.0, borderType=cv2.BORDER_CONSTANT)
    bottom = cv2.GaussianBlur(confidence, size, 1.0, borderType=cv2.BORDER_CONSTANT)
    return top / np.where(bottom > 0, bottom, np.float32(np.nan))
