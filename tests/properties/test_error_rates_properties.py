"""Rates and curves agree with each other and with plain counting."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rangeface.decide import threshold_at_fmr
from rangeface.evaluation.curves import cmc, det
from rangeface.evaluation.error_rates import (
    eer,
    failure_to_acquire,
    fmr,
    fnmr,
    fnmr_at_fmr,
    mated_nonmated,
    rank_k,
)
from rangeface.evaluation.open_set import fnir, fnir_at_fpir, fpir

SEEDS = st.integers(0, 10_000)


def table(seed: int, people: int = 12, each: int = 3, failed: int = 2):
    rng = np.random.default_rng(seed)
    names = np.array([f"p{i}" for i in range(people)])
    probes = np.repeat(names, each)
    scores = rng.standard_normal((len(probes), people)) + 1.5 * (probes[:, None] == names)
    scores[rng.choice(len(probes), failed, replace=False)] = np.nan
    return scores, probes, names


@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_ranks_are_those_of_sorting(seed):
    scores, probes, names = table(seed)
    hits = [p in names[np.argsort(-row)[:3]] for row, p in zip(scores, probes, strict=True)]
    failed = np.isnan(scores).all(axis=1)
    assert rank_k(scores, probes, names, k=3).count == (np.array(hits) & ~failed).sum()
    curve = cmc(scores, probes, names)
    assert curve[0] == rank_k(scores, probes, names).rate
    assert curve[-1] == 1 - failure_to_acquire(scores).rate
    assert (np.diff(curve) >= 0).all()


@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_the_equal_error_rate_lies_between_both_rates_at_every_threshold(seed):
    scores, probes, names = table(seed)
    mated, nonmated = mated_nonmated(scores, probes, names)
    rate = eer(mated, nonmated)
    assert rate.low <= rate.rate <= rate.high
    for t in np.append(mated[~np.isnan(mated)], [-9, 9]):
        pair = sorted([fmr(nonmated, t).rate, fnmr(mated, t).rate])
        assert pair[0] - 1e-12 <= rate.rate <= pair[1] + 1e-12


@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_a_monotone_map_of_scores_changes_no_rate(seed):
    scores, probes, names = table(seed)
    mated, nonmated = mated_nonmated(scores, probes, names)
    bent = [np.exp(s / 2) for s in (mated, nonmated)]
    assert eer(mated, nonmated) == eer(*bent)
    assert fnmr_at_fmr(mated, nonmated, 0.05) == fnmr_at_fmr(*bent, 0.05)
    np.testing.assert_array_equal(det(mated, nonmated).fnmr, det(*bent).fnmr)


@given(SEEDS, st.floats(0.01, 0.5), st.booleans())
@settings(max_examples=50, deadline=None)
def test_the_threshold_is_the_smallest_that_holds_the_rate(seed, wanted, ties):
    nonmated = np.random.default_rng(seed).standard_normal(400)
    if ties:
        nonmated = nonmated.round(1)
    t = threshold_at_fmr(nonmated, wanted)
    assert fmr(nonmated, t).rate <= wanted + 1e-9
    lower = nonmated[nonmated < t]
    assert fmr(nonmated, lower.max()).rate > wanted - 1e-9


def test_the_curve_is_the_two_rates():
    scores, probes, names = table(1)
    mated, nonmated = mated_nonmated(scores, probes, names)
    curve = det(mated, nonmated)
    for t, a, b in zip(curve.thresholds, curve.fmr, curve.fnmr, strict=True):
        assert a == fmr(nonmated, t).rate
        assert b == fnmr(mated, t).rate
    x, y = curve.probit()
    assert x.shape == y.shape == curve.fmr.shape


def test_a_failed_probe_is_an_error_everywhere_and_a_false_match_nowhere():
    scores, probes, names = table(2, failed=0)
    worse = scores.copy()
    worse[0] = np.nan
    assert failure_to_acquire(worse).count == 1
    for k in (1, 5):
        lost = rank_k(scores, probes, names, k=k).count - rank_k(worse, probes, names, k=k).count
        assert lost in (0, 1)
    mated, nonmated = mated_nonmated(worse, probes, names)
    assert fnmr(mated, -np.inf).count == 1
    assert fmr(nonmated, -np.inf).n == nonmated.size - len(names) + 1
    assert fnir(worse, probes, names, -np.inf, k=99).count == 1
    assert fpir(worse, -np.inf).n == len(worse) - 1


def test_a_table_of_equal_scores_hits_nobody():
    scores, probes, names = table(0, failed=0)
    assert rank_k(np.zeros_like(scores), probes, names).count == 0


def test_several_columns_of_one_person_count_by_the_best():
    rate = rank_k([[1.0, 5.0, 3.0]], ["a"], ["a", "a", "b"])
    assert rate.count == 1
    assert rank_k([[1.0, 2.0, 3.0]], ["a"], ["a", "a", "b"], k=2).count == 1


def test_open_set_rates_count_searches():
    scores = np.array([[3.0, 0.0], [0.0, 1.0], [4.0, 2.0]])
    people, names = ["a", "b", "b"], ["a", "b"]
    assert fnir(scores, people, names, 2.0).count == 2  # b too low; b behind a
    assert fnir(scores, people, names, 2.0, k=2).count == 1
    strangers = np.random.default_rng(0).standard_normal((300, 2))
    rate = fnir_at_fpir(scores, people, names, strangers, 0.05)
    assert rate.n == 3
    best = strangers.max(axis=1)
    assert fpir(strangers, threshold_at_fmr(best, 0.05)).rate == pytest.approx(0.05)
