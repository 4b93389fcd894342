"""Profiles: arc length, gaps, symmetry."""

import numpy as np
import pytest

from rangeface import describe
from rangeface.numerics import profiles
from rangeface.types import Orthographic, RangeImage


def face(shift_mm=0.0, roll=0.0, noise=0.0, seed=0):
    camera = Orthographic(2.0, 34.5, 50.0, 70, 100)
    v, u = np.mgrid[0:100, 0:70]
    x, y = (u - camera.cx) * 2.0, (v - camera.cy) * 2.0
    x, y = np.cos(roll) * x + np.sin(roll) * y - shift_mm, -np.sin(roll) * x + np.cos(roll) * y
    z = 18 + x**2 / 160 + y**2 / 500
    z -= 18 * np.exp(-(x**2) / 120 - y**2 / (np.where(y < 0, 900, 120)))
    for side in (-1, 1):
        z += 5 * np.exp(-((x - 30 * side) ** 2) / 150 - (y + 38) ** 2 / 100)
    z += np.random.default_rng(seed).normal(0, noise, z.shape)
    return RangeImage(z, camera)


def test_arc_length_on_a_circle():
    """On a cylinder of radius R the depth at arc length s is R (1 − cos(s/R))."""
    R = 40.0
    x = np.arange(-30.0, 31.0)
    z = np.tile(R - np.sqrt(R**2 - x**2), (3, 1))
    found = profiles.lines(z, (30, 1), [0.0], pitch=1.0, reach=32.0, points=33)[0]
    s = np.linspace(-32, 32, 33)
    np.testing.assert_allclose(found, R * (1 - np.cos(s / R)), atol=0.02)


def test_without_arc_length_the_line_itself_is_sampled():
    z = np.tile(np.arange(21.0) ** 2, (3, 1))
    found = profiles.lines(z, (10, 1), [0.0], pitch=1.0, reach=4, points=9, arc_length=False)[0]
    np.testing.assert_allclose(found, np.arange(6.0, 15.0) ** 2, atol=1e-3)


def test_gaps_are_marked_and_keep_their_length():
    z = np.zeros((3, 41))
    z[:, 26:31] = np.nan
    found = profiles.lines(z, (20, 1), [0.0], pitch=1.0, reach=20, points=41)[0]
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(found)), np.arange(26, 31))
    beyond = profiles.lines(z, (20, 1), [0.0], pitch=1.0, reach=25, points=51)[0]
    assert np.isnan(beyond[[0, -1]]).all()  # the surface ends


def test_gap_at_the_nose_tip_leaves_the_rest_in_place():
    z = np.zeros((3, 41))
    z[:, 19:22] = np.nan
    found = profiles.lines(z, (20, 1), [0.0], pitch=1.0, reach=20, points=41)[0]
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(found)), [19, 20, 21])


def test_noise_is_weighed_by_sigma():
    z = np.zeros((3, 9))
    z[0] = 9.0
    sigma = np.ones((3, 9))
    sigma[0] = 100.0
    found = profiles.lines(
        z, (4, 1), [0.0], pitch=1.0, reach=2, points=5, half_width=1.0, sigma=sigma
    )
    assert np.abs(found).max() < 4.0  # the rows between are half of either


@pytest.mark.parametrize(("shift_mm", "roll_deg"), [(0, 0), (4, 0), (-3, 4), (2, -5)])
def test_symmetry_line_is_found_under_noise(shift_mm, roll_deg):
    image = face(shift_mm, np.deg2rad(roll_deg), noise=1.0)
    offset, roll = describe.symmetry_line(image)
    assert offset == pytest.approx(shift_mm, abs=0.7)
    assert np.rad2deg(roll) == pytest.approx(roll_deg, abs=0.7)


def test_profile_of_a_shifted_face_by_symmetry_is_that_of_the_face():
    plain = describe.vertical_profile(face(), by="symmetry")
    shifted = describe.vertical_profile(face(shift_mm=4.0), by="symmetry")
    np.testing.assert_allclose(plain, shifted, atol=0.5)


def test_nose_root_is_the_hollow_above_the_nose():
    y_mm = describe.profile_height(face(), "root")
    assert -62 <= y_mm <= -30
    assert describe.profile_height(face(), "forehead") == pytest.approx(y_mm - 28)


def test_radial_curves_are_the_profiles():
    """The curve to the right is the right half of the horizontal profile."""
    image = face()
    radial = describe.radial_curves(image, reach_mm=60, points=30).reshape(24, 30)
    horizontal = describe.horizontal_profile(image, half_width_mm=1.0)
    np.testing.assert_allclose(radial[0], horizontal[31:], atol=1e-4)
    np.testing.assert_allclose(radial[12], horizontal[29::-1], atol=1e-4)
