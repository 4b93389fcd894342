"""Decisions, norms and sequences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rangeface.decide import (
    decide_sequence,
    majority_vote,
    open_set,
    per_subject,
    refuse,
    robust_norm,
    s_norm,
    sum_of_scores,
    t_norm,
    verify,
    z_norm,
)
from rangeface.types import Assessment, Reason, Verdict

NAMES = ("ann", "bob", "cy")
UNFIT = Assessment(0, 50, 0, 0.4, 0.3, 2.0, 400, 3.0, 0.5, (Reason.POSE, Reason.LOW_OVERLAP))
FIT = Assessment(0, 0, 0, 1.0, 0.9, 1.0, 400, 1.0, 0.9)
SEEDS = st.integers(0, 10_000)


def test_the_three_answers():
    accepted = open_set([3.0, 1.0, 2.0], NAMES, FIT, threshold=2.5, margin=0.5)
    assert (accepted.verdict, accepted.subject, accepted.score) == (Verdict.ACCEPTED, "ann", 3.0)
    assert accepted.reason is None
    assert accepted.ranking == (("ann", 3.0), ("cy", 2.0), ("bob", 1.0))
    unknown = open_set([2.4, 1.0, 2.0], NAMES, threshold=2.5)
    assert (unknown.verdict, unknown.reason) == (Verdict.UNKNOWN, Reason.BELOW_THRESHOLD)
    assert unknown.subject is None
    alike = open_set([3.0, 1.0, 2.8], NAMES, threshold=2.5, margin=0.5)
    assert (alike.verdict, alike.reason) == (Verdict.CANNOT_TELL, Reason.AMBIGUOUS)


def test_a_tie_is_never_broken_by_the_order_of_enrolment():
    assert open_set([3.0, 3.0], NAMES[:2], threshold=1.0).reason is Reason.AMBIGUOUS


def test_quality_is_asked_first():
    for scores in ([9.0, 0.0, 0.0], [np.nan] * 3):
        refused = open_set(scores, NAMES, UNFIT, threshold=1.0)
        assert (refused.verdict, refused.reason) == (Verdict.CANNOT_TELL, Reason.POSE)
        assert np.isnan(refused.score)
    assert verify(9.0, "ann", UNFIT, threshold=1.0).reason is Reason.POSE


def test_an_empty_gallery_knows_nobody():
    empty = open_set([], (), threshold=1.0)
    assert (empty.verdict, empty.reason) == (Verdict.UNKNOWN, Reason.EMPTY_GALLERY)


def test_missing_scores_are_left_out():
    assert open_set([np.nan, 2.0, np.nan], NAMES, threshold=1.0).ranking == (("bob", 2.0),)
    assert open_set([np.nan] * 3, NAMES, threshold=1.0).verdict is Verdict.CANNOT_TELL
    assert refuse(Reason.NO_FACE).reason is Reason.NO_FACE


def test_verification_is_a_search_among_one():
    assert verify(2.0, "ann", FIT, threshold=2.0).subject == "ann"
    assert verify(1.9, "ann", threshold=2.0).verdict is Verdict.UNKNOWN


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_the_best_of_each_person(seed):
    rng = np.random.default_rng(seed)
    scores = rng.standard_normal((4, 30)).astype(np.float32)
    owners = rng.permutation(np.arange(30) % 5)
    expected = np.stack([scores[:, owners == k].max(axis=1) for k in range(5)], axis=1)
    np.testing.assert_array_equal(per_subject(scores, owners, count=5), expected)
    np.testing.assert_array_equal(per_subject(scores[0], owners, count=5), expected[0])


def test_a_person_without_a_comparison_has_no_score():
    best = per_subject([[1.0, np.nan, np.nan]], [0, 0, 1], count=3)
    np.testing.assert_array_equal(best, [[1.0, np.nan, np.nan]])


@given(SEEDS, st.floats(0.1, 10), st.floats(-5, 5))
@settings(max_examples=30, deadline=None)
def test_norms_undo_each_probes_or_templates_own_scale(seed, gain, offset):
    """A norm is there to be invariant to what it normalises."""
    rng = np.random.default_rng(seed)
    scores, rows, columns = (rng.standard_normal(s) for s in ((6, 8), (6, 20), (20, 8)))
    a = gain * np.arange(1, 7)[:, None]
    np.testing.assert_allclose(t_norm(a * scores + offset), t_norm(scores), atol=1e-9)
    np.testing.assert_allclose(robust_norm(a * scores + offset), robust_norm(scores), atol=1e-9)
    np.testing.assert_allclose(
        t_norm(a * scores + offset, a * rows + offset), t_norm(scores, rows), atol=1e-9
    )
    b = gain * np.arange(1, 9)
    np.testing.assert_allclose(
        z_norm(b * scores + offset, b * columns + offset), z_norm(scores, columns), atol=1e-9
    )
    np.testing.assert_allclose(
        s_norm(scores, rows, columns),
        (t_norm(scores, rows) + z_norm(scores, columns)) / 2,
        atol=1e-12,
    )


def test_norms_keep_failed_probes_and_constant_rows_finite():
    scores = np.array([[1.0, 2.0, 4.0], [np.nan] * 3, [5.0, 5.0, 5.0], [1.0, np.nan, 3.0]])
    for norm in (t_norm, robust_norm):
        out = norm(scores)
        np.testing.assert_array_equal(np.isnan(out), np.isnan(scores))
        np.testing.assert_array_equal(out[2], 0.0)


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_a_majority_is_counted_and_ties_go_to_the_larger_sum(seed):
    rng = np.random.default_rng(seed)
    scores = rng.standard_normal((6, 4))
    votes = np.bincount(scores.argmax(axis=1), minlength=4)
    shares = majority_vote(scores)
    np.testing.assert_allclose(shares, votes / 6, atol=1e-3)
    leaders = np.flatnonzero(votes == votes.max())
    assert shares.argmax() == leaders[scores.sum(axis=0)[leaders].argmax()]


def test_failed_frames_neither_vote_nor_add():
    scores = np.array([[2.0, 1.0], [np.nan, np.nan], [2.0, 1.0], [0.0, 9.0]])
    np.testing.assert_allclose(sum_of_scores(scores), [4 / 3, 11 / 3])
    assert majority_vote(scores).argmax() == 0


def test_a_sequence_that_is_too_short_says_so():
    scores = np.array([[2.0, 1.0, 0.0], [np.nan] * 3])
    short = decide_sequence(scores, NAMES, threshold=1.0, min_frames=2)
    assert (short.verdict, short.reason) == (Verdict.CANNOT_TELL, Reason.TOO_FEW_FRAMES)
    assert decide_sequence(scores, NAMES, threshold=1.0).subject == "ann"
    voted = decide_sequence(scores, NAMES, threshold=0.9, rule="majority")
    assert voted.subject == "ann"
    assert voted.score == pytest.approx(1.0, abs=1e-3)
    nobody = decide_sequence(np.empty((2, 0)), (), threshold=1.0)
    assert nobody.reason is Reason.EMPTY_GALLERY
