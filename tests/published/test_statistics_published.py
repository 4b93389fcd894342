"""Printed values."""

import numpy as np
import pytest

from rangeface.numerics.statistics import clopper_pearson, holm, mcnemar, rule_of_three, wilson


@pytest.mark.parametrize(
    ("count", "n", "low", "high"),
    [
        # R. Newcombe, Stat. Med. 17(8), 1998, table I: method 3 (score) and method 5 (exact)
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_wilson(count, n, low, high):
    assert wilson(count, n) == pytest.approx((low, high), abs=5e-5)


@pytest.mark.parametrize(
    ("count", "n", "low", "high"),
    [
        (81, 263, 0.2527, 0.3676),
        (15, 148, 0.0578, 0.1617),
        (0, 20, 0.0, 0.1684),
        (1, 29, 0.0009, 0.1776),
    ],
)
def test_clopper_pearson(count, n, low, high):
    assert clopper_pearson(count, n) == pytest.approx((low, high), abs=5e-5)


def test_the_source_papers_best_rate():
    """92 % are 55 of 60 (Ebers et al., Table 2): its interval is 82 … 96 %."""
    low, high = wilson(55, 60)
    assert (round(100 * low), round(100 * high)) == (82, 96)


def test_exact_mcnemar_is_a_binomial_test():
    # 1 against 9 discordant pairs: 2 (1 + 10) / 2¹⁰
    first = np.array([True] * 9 + [False] + [True] * 30)
    second = np.array([False] * 9 + [True] + [True] * 30)
    assert mcnemar(first, second) == pytest.approx(2 * 11 / 1024)
    assert mcnemar(first, first) == 1.0


def test_holm_steps_down():
    # 0.01 × 4, 0.02 × 3 → 0.06, 0.022 × 2 → raised to 0.06, 0.9 × 1
    assert holm([0.02, 0.01, 0.9, 0.022]) == pytest.approx([0.06, 0.04, 0.9, 0.06])


def test_rule_of_three():
    assert rule_of_three(300) == 0.01
    assert rule_of_three(2) == 1.0
