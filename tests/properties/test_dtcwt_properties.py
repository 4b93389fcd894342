"""Theorems about the dual-tree transform, and what sets it apart from the DWT."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rangeface.errors import ParameterError
from rangeface.numerics import dtcwt, dwt

BANKS = [
    ("near_sym_a", "qshift_06"),
    ("near_sym_a", "qshift_a"),
    ("near_sym_b", "qshift_b"),
    ("near_sym_b", "qshift_c"),
    ("near_sym_b", "qshift_d"),
    ("selesnick", "qshift_06"),
]


@pytest.mark.parametrize(("first", "further"), BANKS)
@settings(max_examples=15, deadline=None)
@given(
    rows=st.integers(1, 60), cols=st.integers(1, 60), levels=st.integers(1, 5), seed=st.integers(0)
)
def test_perfect_reconstruction_of_any_size(first, further, rows, cols, levels, seed):
    x = np.random.default_rng(seed % 2**32).normal(400.0, 50.0, (rows, cols))
    pyramid = dtcwt.forward_2d(x, levels=levels, first=first, further=further)
    y = dtcwt.inverse_2d(pyramid)
    assert y.dtype == np.float32
    assert y.shape == x.shape
    assert np.abs(y - x).max() <= 1e-4 * np.abs(x).max()


@settings(max_examples=25, deadline=None)
@given(length=st.integers(1, 200), levels=st.integers(1, 6), seed=st.integers(0))
def test_perfect_reconstruction_in_one_dimension(length, levels, seed):
    x = np.random.default_rng(seed % 2**32).normal(400.0, 50.0, length)
    y = dtcwt.inverse_1d(dtcwt.forward_1d(x, levels=levels))
    assert np.abs(y - x).max() <= 1e-4 * np.abs(x).max()


def test_a_batch_equals_its_members():
    x = np.random.default_rng(0).normal(size=(2, 3, 21, 34))
    many = dtcwt.forward_2d(x, levels=3)
    one = dtcwt.forward_2d(x[1, 2], levels=3)
    np.testing.assert_array_equal(many.lowpass[1, 2], one.lowpass)
    for a, b in zip(many.highpasses, one.highpasses, strict=True):
        np.testing.assert_array_equal(a[1, 2], b)
    np.testing.assert_array_equal(dtcwt.inverse_2d(many)[1, 2], dtcwt.inverse_2d(one))
    signals = x.reshape(6, -1)
    lines = dtcwt.forward_1d(signals, levels=3)
    np.testing.assert_array_equal(
        lines.highpasses[1][4], dtcwt.forward_1d(signals[4], levels=3).highpasses[1]
    )


def test_the_transform_is_linear():
    rng = np.random.default_rng(1)
    x, y = rng.normal(size=(2, 30, 42))
    a, b, c = (dtcwt.forward_2d(v, levels=3) for v in (x, y, 2.0 * x - 3.0 * y))
    for p, q, r in zip(a.highpasses, b.highpasses, c.highpasses, strict=True):
        np.testing.assert_allclose(r, 2.0 * p - 3.0 * q, atol=2e-5)


def step_energies(energies_of):
    """Energy of each level's details for an edge at 16 sub-sequent places."""
    found = []
    for shift in range(16):
        x = np.zeros(128)
        x[56 + shift :] = 1.0
        found.append(energies_of(x))
    return np.array(found)


def relative_spread(energies):
    return energies.std(axis=0) / energies.mean(axis=0)


@pytest.mark.parametrize(("first", "further"), BANKS)
def test_sub_band_energy_hardly_depends_on_where_an_edge_is(first, further):
    """Near shift invariance (Kingsbury 2001), against the DWT on the same edges."""

    def dual_tree(x):
        image = np.tile(x, (32, 1))
        pyramid = dtcwt.forward_2d(image, levels=3, first=first, further=further)
        # inside, away from the borders of the periodic bank
        return [
            np.sum(np.abs(w[..., w.shape[-1] // 4 : -w.shape[-1] // 4]) ** 2)
            for w in pyramid.highpasses[1:]
        ]

    def critically_sampled(x):
        bands = dwt.forward(np.tile(x, (32, 1)), wavelet="db4", levels=3)
        return [sum(np.sum(band**2) for band in detail) for detail in bands.details[1:]]

    ours, theirs = map(relative_spread, map(step_energies, (dual_tree, critically_sampled)))
    assert (ours < (0.2 if further == "qshift_06" else 0.12)).all()
    assert (ours < 0.5 * theirs).all()


def wave(angle_deg, period_px=5.0, size=96):
    """A plane wave whose crests run at an angle from the horizontal, counter-clockwise."""
    v, u = np.mgrid[:size, :size].astype(float)
    crest = np.deg2rad(angle_deg)
    return np.cos(2 * np.pi / period_px * (u * np.sin(crest) + v * np.cos(crest)))


@pytest.mark.parametrize(("first", "further"), BANKS)
def test_six_orientations_are_separated(first, further):
    """Each of six plane waves, 30° apart, lives in a sub-band of its own."""
    strongest = []
    for angle in (20, 45, 70, -70, -45, -20):
        pyramid = dtcwt.forward_2d(wave(angle), levels=2, first=first, further=further)
        inner = pyramid.highpasses[1][:, 6:-6, 6:-6]
        energy = np.sum(np.abs(inner) ** 2, axis=(1, 2))
        strongest.append(int(np.argmax(energy)))
        # and its mirror image, which a real separable wavelet confuses it with, is quiet
        assert energy[5 - strongest[-1]] < 0.25 * energy.max()
    assert strongest == list(range(6))


def test_magnitude_follows_an_oscillation_smoothly_where_its_phase_turns():
    """Eq. 3.3 and 3.4: |w| of a wave is nearly constant; arg w advances steadily."""
    x = np.cos(2 * np.pi * np.arange(256) / 6.0)
    w = dtcwt.forward_1d(x, levels=2).highpasses[1][8:-8]
    assert np.abs(w).std() < 0.05 * np.abs(w).mean()
    turns = np.diff(np.unwrap(np.angle(w)))
    assert turns.std() < 0.1 * np.abs(turns.mean())


@pytest.mark.parametrize(
    ("parameters", "name"),
    [({"levels": 0}, "levels"), ({"first": "haar"}, "first"), ({"further": "db4"}, "further")],
)
@pytest.mark.parametrize("forward", [dtcwt.forward_1d, dtcwt.forward_2d])
def test_wrong_parameters_are_named(forward, parameters, name):
    with pytest.raises(ParameterError, match=name):
        forward(np.zeros((8, 8)), **parameters)


def test_a_line_is_not_an_image():
    with pytest.raises(ParameterError, match="image"):
        dtcwt.forward_2d(np.zeros(8))
