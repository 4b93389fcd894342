"""What makes the published filters what they are; the numbers themselves are designs."""

import numpy as np
import pytest

from rangeface.numerics.dtcwt.filters import FARRAS, NEAR_SYM, Q_SHIFT

ORTHONORMAL = {**Q_SHIFT, "farras": FARRAS}


def halfband_error(h, g):
    """Distance of h * g from a half-band filter with centre 1/2 (unit DC gain)."""
    product = np.convolve(h, g)
    centre = len(product) // 2
    target = np.zeros_like(product)
    target[centre] = 0.5
    return np.abs((product - target)[centre % 2 :: 2]).max()


@pytest.mark.parametrize("name", NEAR_SYM)
def test_first_level_filters_reconstruct_and_are_symmetric(name):
    """Biorthogonal: H₀G₀ is half-band (Kingsbury 2001, section 3)."""
    f = NEAR_SYM[name]
    for taps in (f.h0, f.g0):
        assert len(taps) % 2 == 1
        np.testing.assert_allclose(taps, taps[::-1])
        assert taps.sum() == pytest.approx(1.0, abs=1e-12)
        # a zero at the highest frequency: constants have no details
        assert np.sum(taps * (-1.0) ** np.arange(len(taps))) == pytest.approx(0.0, abs=1e-12)
    assert halfband_error(f.h0, f.g0) < 1e-12


@pytest.mark.parametrize("name", ORTHONORMAL)
def test_further_filters_are_orthonormal_to_their_even_shifts(name):
    h = ORTHONORMAL[name].h0
    lags = np.correlate(h, h, mode="full")[len(h) - 1 :: 2]
    tolerance = 1e-7 if name == "farras" else 5e-11
    np.testing.assert_allclose(lags, [1.0] + [0.0] * (len(lags) - 1), atol=tolerance)
    assert h.sum() == pytest.approx(np.sqrt(2.0), abs=1e-7)


@pytest.mark.parametrize("name", ORTHONORMAL)
def test_low_and_high_pass_are_orthogonal(name):
    f = ORTHONORMAL[name]
    lags = np.correlate(f.h0, f.h1, mode="full")[len(f.h0) % 2 + 1 :: 2]
    np.testing.assert_allclose(lags, 0.0, atol=1e-7)


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [
        ("qshift_06", 0.25),  # 10 taps are too few to do better
        ("qshift_a", 0.25),
        ("qshift_b", 0.06),
        ("qshift_c", 0.06),
        ("qshift_d", 0.06),
    ],
)
def test_the_trees_differ_by_half_a_sample_in_the_passband(name, tolerance):
    """Delay 1/4 sample off centre, so the time-reversed tree is 1/2 sample apart (q-shift)."""
    h = Q_SHIFT[name].h0
    w = np.linspace(0.15 * np.pi, 0.35 * np.pi, 40)
    n = np.arange(len(h)) - (len(h) - 1) / 2.0
    a = np.exp(-1j * np.outer(w, n)) @ h
    b = np.exp(-1j * np.outer(w, n)) @ h[::-1]
    delay = np.angle(a / b) / w
    np.testing.assert_allclose(np.abs(delay), 0.5, atol=tolerance)


def test_farras_trees_differ_by_one_sample_at_the_first_level():
    """At level 1 the trees must be one sample apart (Selesnick et al. 2005)."""
    h = FARRAS.h0
    w = np.linspace(0.05, 0.35 * np.pi, 40)
    n = np.arange(len(h))
    # the reverse is read one sample later, which takes one off the delay
    reverse = np.exp(-1j * np.outer(w, n - 1)) @ h[::-1]
    delay = np.angle((np.exp(-1j * np.outer(w, n)) @ h) / reverse) / w
    np.testing.assert_allclose(delay, 1.0, atol=0.15)


def test_near_sym_a_is_the_rational_5_7_pair():
    f = NEAR_SYM["near_sym_a"]
    np.testing.assert_allclose(f.h0 * 20, [-1, 5, 12, 5, -1])
    np.testing.assert_allclose(f.g0 * 280, [-3, -15, 73, 170, 73, -15, -3])
