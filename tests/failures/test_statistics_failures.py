"""What the statistics refuse."""

import numpy as np
import pytest

from rangeface.errors import DegenerateError, ParameterError
from rangeface.numerics.statistics import (
    bootstrap_over_groups,
    clopper_pearson,
    holm,
    mcnemar,
    permutation_test,
    rule_of_three,
    wilson,
)

RNG = np.random.default_rng(0)


@pytest.mark.parametrize("interval", [wilson, clopper_pearson])
@pytest.mark.parametrize(("count", "n"), [(-1, 5), (6, 5), (0, 0)])
def test_impossible_counts(interval, count, n):
    with pytest.raises(ParameterError, match="successes"):
        interval(count, n)


@pytest.mark.parametrize("interval", [wilson, clopper_pearson])
@pytest.mark.parametrize("confidence", [0.0, 1.0, np.nan])
def test_impossible_confidence(interval, confidence):
    with pytest.raises(ParameterError, match="confidence"):
        interval(1, 5, confidence=confidence)


def test_rule_of_three_needs_a_trial():
    with pytest.raises(ParameterError, match="n:"):
        rule_of_three(0)


def test_a_bootstrap_needs_two_groups_and_a_draw():
    with pytest.raises(DegenerateError, match="two"):
        bootstrap_over_groups(np.mean, ["a", "a"], rng=RNG)
    with pytest.raises(ParameterError, match="resamples"):
        bootstrap_over_groups(np.mean, ["a", "b"], rng=RNG, resamples=0)
    with pytest.raises(ParameterError, match="confidence"):
        bootstrap_over_groups(np.mean, ["a", "b"], rng=RNG, confidence=1.5)


def test_paired_tests_need_pairs():
    with pytest.raises(ParameterError, match="paired"):
        mcnemar([True], [True, False])
    with pytest.raises(ParameterError, match="paired"):
        permutation_test([1.0], [1.0, 2.0], rng=RNG)
    with pytest.raises(ParameterError, match="resamples"):
        permutation_test([1.0], [2.0], rng=RNG, resamples=0)


@pytest.mark.parametrize("p", [[-0.1], [1.1], [np.nan], 0.5])
def test_p_values_are_probabilities(p):
    with pytest.raises(ParameterError, match="p_values"):
        holm(p)
