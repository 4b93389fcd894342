"""The paper's operators, worked by hand from their definitions."""

import numpy as np

from rangeface import describe
from rangeface.numerics import gradients, patterns, sphere
from rangeface.types import Orthographic, RangeImage


def test_3dlbp_worked_by_hand():
    """Paper, section on LBP: sign bit, then three bits of the size, sizes from 7 on are 7.

    Radius 1: the four neighbours at the sides are whole pixels, the diagonal ones follow by
    interpolation (weight of a side 0.70711 · 0.29289 = 0.20710, of the corner 0.50000).

         0   +3   0        right  −9 → sign 0, size 9 → 7 = 111
         6    0  −9        down   +1 → sign 1, size 1     = 001
         0   +1   0        left   +6 → sign 1, size 6     = 110
                           up     +3 → sign 1, size 3     = 011

    down right: 0.2071 (−9 + 1) = −1.657 → sign 0, size 2 = 010
    down left:  0.2071 (6 + 1)  = +1.450 → sign 1, size 1 = 001
    up left:    0.2071 (6 + 3)  = +1.864 → sign 1, size 2 = 010
    up right:   0.2071 (−9 + 3) = −1.243 → sign 0, size 1 = 001
    Bits 0 … 7: right, down right, down, down left, left, up left, up, up right.
    """
    image = [[0, 3, 0], [6, 0, -9], [0, 1, 0]]
    signs = 0b01111100
    fours = 0b00010001  # right, left
    twos = 0b01110011  # right, down right, left, up left, up
    ones = 0b11001101  # right, down, down left, up, up right
    np.testing.assert_array_equal(
        patterns.tdlbp(image, unit=1.0)[:, 1, 1], [signs, fours, twos, ones]
    )


def test_unit_scales_the_sizes():
    image = np.array([[0, 3, 0], [6, 0, -9], [0, 1, 0]])
    np.testing.assert_array_equal(
        patterns.tdlbp(0.55 * image, unit=0.55), patterns.tdlbp(image, unit=1.0)
    )


def test_hso_by_hand():
    """Eq. 3.8 on 3 × 3 numbers: (3 − 1) + 2 (7 − 4) + (9 − 2) = 15."""
    assert gradients.hso([[1, 5, 3], [4, 0, 7], [2, 8, 9]])[1, 1] == 15


def test_lhg_by_hand():
    """(−1 0 0 0 1): 11 − 2 = 9."""
    rows = np.tile([2.0, 3.0, 5.0, 7.0, 11.0], (5, 1))
    assert gradients.lhg(rows)[2, 2] == 9


def test_gradients_are_of_the_grey_image_in_which_near_is_bright():
    depth = np.tile(np.arange(6.0), (6, 1))  # falls back to the right
    image = RangeImage(depth, Orthographic(2.0, 3, 3, 6, 6))
    assert describe.hso(image)[3, 3] == -8
    assert describe.lhg(image)[3, 3] == -4


def test_incomplete_pairs_count_as_level():
    image = np.tile(np.arange(6.0), (6, 1))
    image[2, 3] = np.nan
    found = gradients.hso(image)
    assert found[2, 3] == 0  # the hole
    assert found[2, 2] == 2 * 2  # rows above and below only: 2 + 0 + 2
    assert np.isfinite(found).all()


def test_eq_3_7_angle_does_not_depend_on_the_stereographic_factor():
    rng = np.random.default_rng(0)
    N = rng.normal(size=(500, 3))
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    pi_N = (N[:, 0] + 1j * N[:, 1]) / (1 - N[:, 2])
    np.testing.assert_allclose(sphere.polar_stereographic(N)[:, 1], np.angle(pi_N), atol=1e-5)


def test_grey_levels_of_the_paper():
    """Nose tip 255, 14 cm behind it 0: 1.82 levels a millimetre."""
    image = RangeImage([[0.0, 70.0, 140.0, 200.0]], Orthographic(2.0, 0, 0, 4, 1))
    np.testing.assert_array_equal(describe.depth_levels(image)[0], [255, 128, 0, 0])
    assert round(255 / 140, 2) == 1.82
