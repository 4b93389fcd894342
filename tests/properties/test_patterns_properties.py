"""Local binary patterns against their definition, and their invariances."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rangeface.numerics import patterns


def differences(image, points, radius):
    """The specification: interpolated differences (P, H, W) in float64, NaN where missing."""
    height, width = image.shape
    margin = int(np.ceil(radius)) + 1
    framed = np.pad(image.astype(float), margin, constant_values=np.nan)
    angle = 2 * np.pi * np.arange(points) / points
    out = []
    for dx, dy in zip(
        np.round(radius * np.cos(angle), 5), np.round(radius * np.sin(angle), 5), strict=True
    ):
        i, j = int(np.floor(dx)), int(np.floor(dy))
        s, t = dx - i, dy - j
        total = np.zeros(image.shape)
        for dj, di, weight in (
            (0, 0, (1 - t) * (1 - s)),
            (0, 1, (1 - t) * s),
            (1, 0, t * (1 - s)),
            (1, 1, t * s),
        ):
            if weight > 0:
                v, u = margin + j + dj, margin + i + di
                total += weight * (framed[v : v + height, u : u + width] - image)
        out.append(total)
    return np.stack(out)


def holed(seed, shape=(14, 11)):
    rng = np.random.default_rng(seed)
    image = np.cumsum(rng.normal(size=shape), axis=0).astype(np.float32)
    image[rng.random(shape) < 0.1] = np.nan
    return image


@pytest.mark.parametrize(("points", "radius"), [(8, 1.0), (8, 1.5), (16, 2.0), (24, 3.0)])
def test_codes_follow_the_definition(points, radius):
    image = holed(points)
    bits = ~(differences(image, points, radius) < 0)  # missing counts as level
    code = (bits * 2 ** np.arange(points)[:, None, None]).sum(axis=0)
    np.testing.assert_array_equal(
        patterns.lbp(image, points=points, radius_px=radius, method="basic"), code
    )
    changes = (bits != np.roll(bits, 1, axis=0)).sum(axis=0)
    riu2 = np.where(changes <= 2, bits.sum(axis=0), points + 1)
    np.testing.assert_array_equal(patterns.lbp(image, points=points, radius_px=radius), riu2)


def test_layers_follow_the_definition():
    image, unit = holed(1), 0.37
    d = differences(image, 8, 1.0)
    size = np.minimum(np.floor(np.abs(np.nan_to_num(d)) / unit + 0.5), 7).astype(int)
    weights = 2 ** np.arange(8)[:, None, None]
    expected = [(~(d < 0) * weights).sum(0)]
    expected += [(((size >> b) & 1) * weights).sum(0) for b in (2, 1, 0)]
    np.testing.assert_array_equal(patterns.tdlbp(image, unit=unit), np.stack(expected))


@pytest.mark.parametrize("points", patterns.POINTS)
@pytest.mark.parametrize("method", ["ri", "riu2"])
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), quarter=st.integers(1, 3))
def test_ri_and_riu2_do_not_change_when_the_image_turns(points, method, seed, quarter):
    """Ojala et al. 2002: exact for turns by multiples of 360°/P that keep the grid."""
    rng = np.random.default_rng(seed)
    image = rng.integers(0, 1000, (9, 9)).astype(np.float32)
    image += rng.random((9, 9)).astype(np.float32)  # no ties: their rounding may differ
    upright = patterns.lbp(image, points=points, radius_px=2.0, method=method)
    turned = patterns.lbp(np.rot90(image, quarter), points=points, radius_px=2.0, method=method)
    np.testing.assert_array_equal(np.rot90(upright, quarter), turned)


@settings(max_examples=20, deadline=None)
@given(shift=st.integers(-500, 500), gain=st.sampled_from([0.5, 2.0, 4.0]), seed=st.integers(0, 99))
def test_codes_ignore_shift_and_gain(shift, gain, seed):
    """A code depends on signs of differences only: any increasing affine map keeps it."""
    image = np.random.default_rng(seed).integers(0, 255, (8, 8)).astype(np.float32)
    np.testing.assert_array_equal(patterns.lbp(image), patterns.lbp(gain * image + shift))


def test_turning_a_code_turns_its_u2_label():
    for ones in range(1, 8):
        labels = {1 + (ones - 1) * 8 + r for r in range(8)}
        found = set()
        for r in range(8):
            code = sum(1 << ((r + k) % 8) for k in range(ones))
            label = float(patterns._label_table(8, "u2")[code])
            assert label == 1 + (ones - 1) * 8 + r
            found.add(label)
        assert found == labels


@pytest.mark.parametrize("method", patterns.METHODS)
@pytest.mark.parametrize("points", patterns.POINTS)
def test_labels_stay_below_their_number(points, method):
    labels = patterns.lbp(holed(2), points=points, radius_px=1.7, method=method)
    assert labels.min() >= 0
    assert labels.max() < patterns.label_count(points, method)


def test_batch_equals_loop():
    batch = np.stack([holed(s) for s in range(4)])
    for method in patterns.METHODS:
        loop = np.stack([patterns.lbp(i, method=method) for i in batch])
        np.testing.assert_array_equal(patterns.lbp(batch, method=method), loop)
    loop = np.stack([patterns.tdlbp(i, unit=0.5) for i in batch])
    np.testing.assert_array_equal(patterns.tdlbp(batch, unit=0.5), loop)


@pytest.mark.parametrize("seed", range(5))
def test_both_patterns_in_one_pass_are_those_of_two(seed: int) -> None:
    rng = np.random.default_rng(seed)
    images = rng.normal(0.0, 3.0, (3, 20, 17)).astype(np.float32)
    images[rng.random(images.shape) < 0.05] = np.nan
    codes, layers = patterns.lbp_and_tdlbp(images, method="riu2", unit=0.55)
    assert np.array_equal(codes, patterns.lbp(images, method="riu2"), equal_nan=True)
    assert np.array_equal(layers, patterns.tdlbp(images, unit=0.55), equal_nan=True)
