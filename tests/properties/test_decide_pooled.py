"""Heads on one scale: invariance, its two limits, and heads that could not compare."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rangeface.decide import no_norm, pooled_norm, robust_norm, sum_rule
from rangeface.errors import DegenerateError, ParameterError

SEEDS = st.integers(0, 10_000)
FEW = settings(max_examples=25, deadline=None)


def table(seed: int, people: int = 9, cohort: int = 15):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((3, people)), rng.standard_normal((3, cohort))


@given(SEEDS, st.floats(0.1, 50.0), st.floats(-20.0, 20.0))
@FEW
def test_a_heads_own_scale_does_not_matter(seed, scale, offset):
    scores, cohort = table(seed)
    a = np.array([1.0, scale, 3.0])[:, None]
    b = np.array([0.0, offset, 5.0])[:, None]
    moved = pooled_norm(a * scores + b, a * cohort + b)
    np.testing.assert_allclose(moved, pooled_norm(scores, cohort), atol=1e-6)


@given(SEEDS)
@FEW
def test_without_a_prior_only_the_gallery_counts(seed):
    scores, cohort = table(seed)
    alone = pooled_norm(scores, cohort, centre_prior=0.0, spread_prior=0.0)
    np.testing.assert_allclose(alone, robust_norm(scores))
    np.testing.assert_allclose(pooled_norm(scores), robust_norm(scores))


@given(SEEDS)
@FEW
def test_with_one_person_enrolled_only_the_cohort_counts(seed):
    scores, cohort = table(seed, people=1)
    alone = pooled_norm(scores, cohort)
    spread = 1.4826 * np.median(np.abs(cohort - np.median(cohort, 1, keepdims=True)), 1)
    np.testing.assert_allclose(alone[:, 0], (scores[:, 0] - np.median(cohort, 1)) / spread)


def test_one_mated_score_hardly_moves_the_others():
    scores, cohort = table(1, people=30)
    mated = scores.copy()
    mated[:, 4] = 1000.0
    others = np.delete(np.arange(30), 4)
    moved = pooled_norm(mated, cohort)[:, others] - pooled_norm(scores, cohort)[:, others]
    assert np.abs(moved).max() < 0.35


def test_a_cohort_that_scores_lower_soon_loses_its_say():
    """A cohort of another sensor lies lower: what a stranger reaches must fall with the gallery."""
    rng = np.random.default_rng(0)
    cohort = rng.standard_normal((1, 60)) - 5.0
    reached = [
        np.mean([pooled_norm(rng.standard_normal((1, n)), cohort).mean() for _ in range(50)])
        for n in (2, 5, 20, 60)
    ]
    assert reached == sorted(reached, reverse=True)
    assert reached[0] > 1.0
    assert reached[-1] < 0.3


def test_a_head_that_could_not_compare_is_left_out_of_the_sum():
    scores, cohort = table(2)
    full = sum_rule(pooled_norm(scores[:2], cohort[:2]))
    scores[2], cohort[2] = np.nan, np.nan
    np.testing.assert_allclose(sum_rule(pooled_norm(scores, cohort)), full)


def test_raw_scores_stay_as_they_are():
    scores, cohort = table(3)
    np.testing.assert_array_equal(no_norm(scores, cohort), scores)


def test_what_cannot_be_normalised_is_refused():
    with pytest.raises(ParameterError, match="expected a table"):
        pooled_norm([1.0, 2.0])
    with pytest.raises(ParameterError, match="expected a table"):
        no_norm([1.0, 2.0])
    for name in ("centre_prior", "spread_prior"):
        with pytest.raises(ParameterError, match=f"{name}: must be ≥ 0"):
            pooled_norm([[1.0, 2.0]], **{name: -1.0})
    with pytest.raises(ParameterError, match="does not fit"):
        pooled_norm([[1.0, 2.0]], [[1.0], [2.0]])
    with pytest.raises(DegenerateError, match="at least two people"):
        pooled_norm([[1.0]])
    with pytest.raises(DegenerateError, match="at least two people"):
        pooled_norm([[1.0]], [[1.0]])
