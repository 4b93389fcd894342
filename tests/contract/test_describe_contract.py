"""Every entry of describe.METHODS keeps its promises about shape, range, holes and input."""

import inspect

import numpy as np
import pytest

from rangeface import describe
from rangeface.errors import DegenerateError, ParameterError
from rangeface.types import Orthographic, Pinhole, RangeImage

HEIGHT, WIDTH = 40, 26


def head(*, holes: bool = False, amplitude: bool = True) -> RangeImage:
    """A bumpy ellipsoid, mm, nose tip at the origin."""
    camera = Orthographic(4.0, 12.5, 19.0, WIDTH, HEIGHT)
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    x, y = (u - camera.cx) * 4.0, (v - camera.cy) * 4.0
    inside = np.maximum(1.0 - (x / 75.0) ** 2 - (y / 105.0) ** 2, 0.0)
    depth = 90.0 * (1.0 - np.sqrt(inside)) - 18.0 * np.exp(-(x**2 + y**2) / 300.0) + 18.0
    depth += 0.8 * np.sin(x / 9.0) * np.cos(y / 7.0)
    if holes:
        depth[inside == 0] = np.nan
        depth[10:13, 5:9] = np.nan
        depth[25, 15] = np.nan
    light = 200.0 + 40.0 * np.cos(x / 20.0) if amplitude else None
    return RangeImage(depth, camera, sigma=np.full(depth.shape, 0.5), amplitude=light)


@pytest.mark.parametrize("name", describe.METHODS)
def test_shape_range_and_finiteness(name):
    output = describe.OUTPUTS[name]
    for image in (head(), head(holes=True)):
        feature = describe.METHODS[name](image)
        assert feature.dtype == np.float32
        assert np.isfinite(feature).all()
        assert feature.min() >= output.low - 1e-6
        assert feature.max() <= output.high + 1e-6
        dimensions = {"image": 2, "channels": 3, "vector": 1, "histogram": 1}[output.kind]
        assert feature.ndim == dimensions
        if dimensions > 1:
            assert feature.shape[:2] == (HEIGHT, WIDTH)


@pytest.mark.parametrize("name", describe.METHODS)
def test_shape_does_not_depend_on_the_holes(name):
    method = describe.METHODS[name]
    assert method(head()).shape == method(head(holes=True)).shape


@pytest.mark.parametrize("name", describe.METHODS)
def test_input_is_untouched_and_result_repeats(name):
    image = head(holes=True)
    before = image.depth.copy()
    first, second = (describe.METHODS[name](image) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(image.depth, before)


REACH_PX = 9
GLOBAL = {"normal_angle", "gabor", "albedo"}  # least squares, wavelets without an end, a median
LOCAL = [n for n, o in describe.OUTPUTS.items() if o.kind in ("image", "channels")]


@pytest.mark.parametrize("name", [name for name in LOCAL if name not in GLOBAL])
def test_a_hole_is_felt_only_near_it(name):
    image, spoilt = head(), head().depth.copy()
    spoilt[30:32, 18:20] = np.nan
    a, b = (describe.METHODS[name](i) for i in (image, image.with_depth(spoilt)))
    far = np.ones((HEIGHT, WIDTH), bool)
    far[30 - REACH_PX : 32 + REACH_PX, 18 - REACH_PX : 20 + REACH_PX] = False
    np.testing.assert_allclose(a[far], b[far], atol=1e-5)


@pytest.mark.parametrize("name", describe.METHODS)
def test_refuses_what_is_not_frontal(name):
    image = head()
    turned = RangeImage(
        image.depth + 400.0, Pinhole(100, 100, 12, 19, WIDTH, HEIGHT), amplitude=image.amplitude
    )
    with pytest.raises(ParameterError, match="frontal"):
        describe.METHODS[name](turned)


@pytest.mark.parametrize("name", describe.METHODS)
def test_refuses_an_empty_image(name):
    image = head()
    with pytest.raises(DegenerateError):
        describe.METHODS[name](image.masked(np.zeros(image.shape, bool)))


def test_tables_name_the_same_methods():
    assert list(describe.METHODS) == list(describe.OUTPUTS)
    for name, method in describe.METHODS.items():
        assert method.__name__ == name
        parameters = list(inspect.signature(method).parameters.values())
        assert all(p.kind is p.KEYWORD_ONLY for p in parameters[1:])


@pytest.mark.parametrize("name", [n for n, o in describe.OUTPUTS.items() if o.needs_amplitude])
def test_infrared_features_ask_for_an_amplitude(name):
    with pytest.raises(ParameterError, match="amplitude"):
        describe.METHODS[name](head(amplitude=False))


@pytest.mark.parametrize("name", describe.UNCERTAINTY)
def test_uncertainty_grows_with_the_noise(name):
    method = describe.UNCERTAINTY[name]
    image = head(holes=True)
    small, large = method(image, sigma_mm=0.5), method(image, sigma_mm=1.0)
    assert small.shape[:2] == image.shape
    assert small.dtype == np.float32
    known = np.isfinite(small)
    assert known[image.mask].mean() > 0.9
    power = 2 if name == "normals" else 1  # a covariance, a standard deviation
    np.testing.assert_allclose(large[known], 2.0**power * small[known], rtol=1e-3, atol=1e-9)
