"""Every entry of METHODS and COMBINE keeps what the stage promises."""

import numpy as np
import pytest

from rangeface.denoise import COMBINE, METHODS
from rangeface.types import Orthographic, Pinhole, RangeImage, RigidTransform

SHAPES = [(1, 1), (3, 2), (31, 45), (64, 48)]


def scene(shape, seed=0, *, holes=0.1, planes=True):
    """A sphere before a wall, 2 mm of noise, holes, and planes where asked for."""
    rng = np.random.default_rng(seed)
    rows, cols = shape
    v, u = np.mgrid[:rows, :cols]
    r2 = ((u - cols / 2) / cols) ** 2 + ((v - rows / 2) / rows) ** 2
    depth = np.where(r2 < 0.15, 400.0 + 300.0 * r2, 700.0) + rng.normal(0.0, 2.0, shape)
    depth[rng.random(shape) < holes] = np.nan
    extra = {}
    if planes:
        extra = {
            "sigma": rng.uniform(1.5, 2.5, shape),
            "amplitude": rng.uniform(50.0, 150.0, shape),
        }
    return RangeImage(depth, Pinhole(200, 210, cols / 2, rows / 2, cols, rows), **extra)


def still(n):
    return [RigidTransform(np.eye(3), np.zeros(3)) for _ in range(n)]


def same(a, b):
    for name in ("depth", "sigma", "amplitude", "filled"):
        x, y = getattr(a, name), getattr(b, name)
        if x is None or y is None:
            assert x is y, name
        else:
            np.testing.assert_array_equal(x, y, err_msg=name)


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("planes", [True, False])
def test_same_grid_input_untouched_and_deterministic(name, shape, planes):
    image = scene(shape, planes=planes)
    before = image.depth.copy()
    first, second = METHODS[name](image), METHODS[name](image)
    np.testing.assert_array_equal(image.depth, before)
    assert first.camera == image.camera
    assert first.depth.dtype == np.float32
    same(first, second)


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("shape", SHAPES)
def test_every_new_pixel_is_marked_as_filled(name, shape):
    image = scene(shape)
    out = METHODS[name](image)
    new = out.mask & ~image.mask
    assert not new.any() or out.filled[new].all()
    if out.filled is not None:
        assert not (out.filled & image.mask).any()


@pytest.mark.parametrize("name", METHODS)
def test_an_image_without_a_valid_pixel_stays_one(name):
    empty = RangeImage(np.full((20, 30), np.nan), Orthographic(2.0, 15, 10, 30, 20))
    assert not METHODS[name](empty).mask.any()


@pytest.mark.parametrize("name", METHODS)
def test_a_single_valid_pixel_is_not_moved(name):
    depth = np.full((20, 30), np.nan)
    depth[7, 9] = 512.0
    out = METHODS[name](RangeImage(depth, Orthographic(2.0, 15, 10, 30, 20)))
    if out.mask[7, 9]:
        assert out.depth[7, 9] == pytest.approx(512.0, abs=1e-2)


@pytest.mark.parametrize("name", METHODS)
def test_what_lies_behind_an_invalid_pixel_does_not_leak(name):
    """The planes of invalid pixels are arbitrary; no valid pixel may depend on them."""
    image = scene((40, 50))
    rng = np.random.default_rng(7)
    sigma = np.where(image.mask, image.sigma, rng.uniform(10, 1e4, image.shape))
    amplitude = np.where(image.mask, image.amplitude, rng.uniform(0, 1e4, image.shape))
    other = RangeImage(image.depth, image.camera, sigma=sigma, amplitude=amplitude)
    a, b = METHODS[name](image), METHODS[name](other)
    np.testing.assert_array_equal(a.mask, b.mask)
    np.testing.assert_allclose(a.depth[image.mask], b.depth[image.mask], atol=1e-3)


@pytest.mark.parametrize("name", METHODS)
def test_a_fronto_parallel_wall_keeps_its_depth(name):
    wall = RangeImage(
        np.full((40, 50), 612.5), Orthographic(2.0, 25, 20, 50, 40), sigma=np.full((40, 50), 2.0)
    )
    out = METHODS[name](wall)
    np.testing.assert_allclose(out.depth[5:-5, 5:-5], 612.5, atol=2e-3)


@pytest.mark.parametrize("name", COMBINE)
def test_one_frame_or_ten_give_an_image_of_the_same_camera(name):
    frames = [scene((24, 32), seed) for seed in range(10)]
    for n in (1, 10):
        out = COMBINE[name](frames[:n], poses=still(n))
        assert out.camera == frames[0].camera
        same(out, COMBINE[name](frames[:n], poses=still(n)))


@pytest.mark.parametrize("name", COMBINE)
def test_one_frame_combined_is_that_frame(name):
    frame = scene((24, 32))
    out = COMBINE[name]([frame], poses=still(1))
    if name != "space_time_convolution":
        np.testing.assert_allclose(out.depth, frame.depth, atol=1e-3)
        np.testing.assert_allclose(out.sigma[out.mask], frame.sigma[out.mask], rtol=1e-4)


@pytest.mark.parametrize("name", COMBINE)
def test_combining_frames_without_planes(name):
    frames = [scene((24, 32), seed, planes=False) for seed in range(4)]
    out = COMBINE[name](frames, poses=still(4))
    assert out.sigma is None
    assert out.mask.any()


@pytest.mark.parametrize("name", COMBINE)
def test_frames_without_a_valid_pixel_give_an_image_without_one(name):
    empty = RangeImage(np.full((20, 30), np.nan), Pinhole(200, 200, 15, 10, 30, 20))
    assert not COMBINE[name]([empty, empty], poses=still(2)).mask.any()
