"""Fusion, calibration and the sequential test keep what they promise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.linear_model import LogisticRegression
from sklearn.utils.estimator_checks import check_estimator

from rangeface.decide import LlrFusion, linear_llr, sequential, sum_rule, weighted_sum
from rangeface.evaluation.held_out import held_out_rates, people_folds
from rangeface.types import Reason, Verdict

SEEDS = st.integers(0, 10_000)
FEW = settings(max_examples=20, deadline=None)


def pairs(seed: int, heads: int = 3, n: int = 2000):
    """Two normal distributions a head, one σ·d apart: the LLR is linear and known."""
    rng = np.random.default_rng(seed)
    mated = rng.random(n) < 0.3
    distance = rng.uniform(0.5, 2.0, heads)
    return rng.standard_normal((n, heads)) + distance * mated[:, None], mated, distance


# ── fusion ───────────────────────────────────────────────────────────────────────────────


def test_scikit_learn_accepts_llr_fusion():
    check_estimator(LlrFusion(), on_skip=None)


@given(SEEDS)
@FEW
def test_a_weighted_sum_is_an_average_over_what_is_there(seed):
    rng = np.random.default_rng(seed)
    scores = rng.standard_normal((4, 5, 6))
    np.testing.assert_allclose(sum_rule(scores), scores.mean(axis=0), atol=1e-6)
    w = rng.random((4, 5))
    np.testing.assert_allclose(
        weighted_sum(scores, weights=w),
        np.einsum("hnm,hn->nm", scores, w) / w.sum(0)[:, None],
        atol=1e-6,
    )
    scores[1] = np.nan
    np.testing.assert_allclose(
        weighted_sum(scores, weights=w), weighted_sum(scores[[0, 2, 3]], weights=w[[0, 2, 3]])
    )


def test_where_nobody_has_a_score_there_is_none():
    assert np.isnan(weighted_sum([[np.nan], [2.0]], weights=[1.0, 0.0])).all()


@given(SEEDS)
@settings(max_examples=6, deadline=None)
def test_llr_of_two_normals_is_the_known_line(seed):
    """log N(s; d, 1) − log N(s; 0, 1) = d·s − d²/2; heads independent: they add."""
    X, mated, d = pairs(seed, n=8000)
    llr = LlrFusion(shrinkage=0.0).fit(X, mated).decision_function(X)
    truth = X @ d - 0.5 * (d**2).sum()
    assert np.corrcoef(llr, truth)[0, 1] > 0.995
    assert np.polyfit(truth, llr, 1)[0] == pytest.approx(1.0, abs=0.2)


@given(SEEDS)
@FEW
def test_without_shrinkage_it_is_balanced_logistic_regression(seed):
    X, mated, _ = pairs(seed)
    ours = LlrFusion(shrinkage=0.0).fit(X, mated)
    Z = (X - ours.centre_) / ours.scale_
    # the same ridge: scikit-learn sums n weighted losses, ours is their mean
    theirs = LogisticRegression(C=1 / (1e-3 * len(X)), class_weight="balanced", tol=1e-8)
    np.testing.assert_allclose(ours.weights_, theirs.fit(Z, mated).coef_[0], atol=1e-3)
    np.testing.assert_allclose(ours.bias_, theirs.intercept_[0], atol=1e-3)


def test_shrinkage_leads_to_equal_weights():
    X, mated, _ = pairs(3)
    spreads = [np.ptp(LlrFusion(shrinkage=s).fit(X, mated).weights_) for s in (0, 0.1, 1, 1e4)]
    assert spreads == sorted(spreads, reverse=True)
    assert spreads[-1] < 1e-3


@given(SEEDS, st.floats(0.1, 10), st.floats(-5, 5))
@FEW
def test_the_scale_of_a_matcher_does_not_matter(seed, gain, offset):
    X, mated, _ = pairs(seed, n=300)
    np.testing.assert_allclose(
        LlrFusion().fit(gain * X + offset, mated).decision_function(gain * X + offset),
        LlrFusion().fit(X, mated).decision_function(X),
        atol=1e-6,
    )


def test_a_missing_score_is_no_evidence():
    X, mated, _ = pairs(5)
    fusion = LlrFusion().fit(X, mated)
    hole = X.copy()
    hole[:, 1] = np.nan
    evidence = fusion.weights_[1] * (X[:, 1] - fusion.centre_[1]) / fusion.scale_[1]
    np.testing.assert_allclose(
        fusion.decision_function(hole), fusion.decision_function(X) - evidence, atol=1e-9
    )
    stack = X.T.reshape(3, 40, 50).copy()
    fused = linear_llr(stack, **fusion.parameters())
    np.testing.assert_allclose(fused, fusion.decision_function(X).reshape(40, 50), atol=1e-12)
    stack[1, 3, 3] = stack[:, 0, 0] = np.nan
    assert np.isnan(linear_llr(stack, **fusion.parameters())).sum() == 1


def test_separable_scores_stay_finite():
    fusion = LlrFusion().fit([[0.0], [0.0], [1.0], [1.0]], [0, 0, 1, 1])
    assert np.isfinite(fusion.decision_function([[-9.0], [9.0]])).all()


# ── the sequential test ──────────────────────────────────────────────────────────────────

NAMES = ("ann", "bob", "cy")


def frames(rng, mean: float, count: int = 40, correlation: float = 0.0, who: int | None = 0):
    """LLRs of normal scores 2 apart, with a share of their noise common to all frames."""
    noise = np.sqrt(1 - correlation) * rng.standard_normal((count, 3))
    noise += np.sqrt(correlation) * rng.standard_normal(3)
    return mean * (noise + mean * (np.arange(3) == who)) - mean**2 / 2


def test_independent_frames_keep_walds_error_rates():
    rng = np.random.default_rng(0)
    mated = [sequential(frames(rng, 1.5), NAMES, correlation=0.0) for _ in range(400)]
    strangers = [sequential(frames(rng, 1.5, who=None), NAMES, correlation=0.0) for _ in range(400)]
    assert np.mean([s.decision.subject == "ann" for s in mated]) > 0.97
    assert np.mean([s.decision.verdict is Verdict.ACCEPTED for s in strangers]) < 0.025
    assert 2 < np.mean([s.frames for s in mated]) < 10


def test_correlated_frames_need_the_cap():
    rng = np.random.default_rng(1)
    sequences = [frames(rng, 1.0, count=100, correlation=0.5, who=None) for _ in range(150)]

    def false_accepts(correlation):
        stopped = [sequential(s, NAMES, correlation=correlation) for s in sequences]
        return np.mean([s.decision.verdict is Verdict.ACCEPTED for s in stopped])

    assert false_accepts(0.5) < 0.02 < false_accepts(0.0)


def test_clear_frames_stop_early_and_unclear_ones_say_so():
    clear = sequential(np.tile([9.0, -9.0, -9.0], (20, 1)), NAMES)
    assert (clear.decision.subject, clear.frames) == ("ann", 1)
    assert sequential(np.tile([9.0, -9.0, -9.0], (20, 1)), NAMES, min_frames=4).frames == 4
    nobody = sequential(np.full((20, 3), -9.0), NAMES)
    assert (nobody.decision.verdict, nobody.frames) == (Verdict.UNKNOWN, 1)
    unclear = sequential(np.tile([0.1, 0.0, 0.0], (20, 1)), NAMES)
    assert unclear.decision.reason is Reason.TOO_FEW_FRAMES
    assert unclear.frames == 20
    for rival in (9.0, 8.0):
        twins = sequential(np.tile([9.0, rival, -9.0], (20, 1)), NAMES)
        assert twins.decision.reason is Reason.AMBIGUOUS
        assert twins.decision.subject is None


def test_failed_frames_bring_no_evidence():
    table = np.full((6, 3), np.nan)
    assert sequential(table, NAMES).decision.reason is Reason.TOO_FEW_FRAMES
    table[4] = [20.0, -20.0, -20.0]
    stopped = sequential(table, NAMES)
    assert (stopped.decision.subject, stopped.frames) == ("ann", 5)
    assert sequential(np.empty((5, 0)), ()).decision.reason is Reason.EMPTY_GALLERY


# ── thresholds on others ─────────────────────────────────────────────────────────────────


@given(SEEDS, st.integers(2, 6))
@FEW
def test_no_person_is_on_both_sides_of_a_fold(seed, folds):
    rng = np.random.default_rng(seed)
    people = rng.integers(0, 9, 60)
    people[:9] = np.arange(9)
    masks = people_folds(people, folds=folds, rng=rng)
    assert (np.sum(masks, axis=0) == 1).all()
    for mask in masks:
        assert not set(people[mask]) & set(people[~mask])


def test_held_out_rates_are_near_the_rate_aimed_at():
    rng = np.random.default_rng(0)
    names = np.arange(80)
    probes = np.repeat(names, 3)
    scores = rng.standard_normal((240, 80)) + 3.0 * (probes[:, None] == names)
    scores[7] = np.nan
    result = held_out_rates(scores, probes, names, fmr=0.01, rng=np.random.default_rng(1))
    assert result.fmr.low <= 0.01 <= result.fmr.high
    assert result.fnmr.n == 240
    assert len(result.thresholds) == 5
