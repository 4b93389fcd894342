"""What decisions refuse."""

import numpy as np
import pytest

from rangeface.decide import (
    LlrFusion,
    decide_sequence,
    linear_llr,
    majority_vote,
    open_set,
    per_subject,
    robust_norm,
    s_norm,
    sequential,
    sum_of_scores,
    t_norm,
    verify,
    weighted_sum,
    z_norm,
)
from rangeface.errors import DegenerateError, ParameterError
from rangeface.evaluation.held_out import held_out_rates, people_folds

TABLE = np.arange(6.0).reshape(2, 3)


def test_open_set():
    with pytest.raises(ParameterError, match="does not fit 1 subjects"):
        open_set([1.0, 2.0], ["ann"], threshold=0.0)
    for bad in ({"threshold": np.nan}, {"margin": -1.0}, {"margin": np.nan}, {"top": 0}):
        with pytest.raises(ParameterError, match="threshold, margin, top"):
            open_set([1.0], ["ann"], **{"threshold": 0.0, **bad})
    with pytest.raises(ParameterError, match="threshold"):
        verify(1.0, "ann", threshold=np.nan)


def test_per_subject():
    with pytest.raises(ParameterError, match="owners"):
        per_subject(TABLE, [0, 1], count=2)
    for owners in ([0, 1, 2], [-1, 0, 1]):
        with pytest.raises(ParameterError, match="owners: must be in 0"):
            per_subject(TABLE, owners, count=2)


def test_norms():
    with pytest.raises(ParameterError, match="cohort"):
        z_norm(TABLE, TABLE[:, :2])
    with pytest.raises(ParameterError, match="cohort"):
        t_norm(TABLE, TABLE[:1])
    with pytest.raises(ParameterError, match="cohort"):
        s_norm(TABLE, TABLE, TABLE[:, :2])
    for norm in (t_norm, robust_norm):
        with pytest.raises(ParameterError, match="scores: expected a table"):
            norm([1.0, 2.0])
        with pytest.raises(DegenerateError, match="at least two"):
            norm([[1.0]])
    with pytest.raises(DegenerateError, match="at least two"):
        z_norm(TABLE, TABLE[:1])


def test_sequences():
    for rule in (majority_vote, sum_of_scores):
        with pytest.raises(ParameterError, match="expected a table"):
            rule([1.0])
        with pytest.raises(DegenerateError, match="no frame"):
            rule([[np.nan, np.nan]])
    with pytest.raises(ParameterError, match="rule: unknown 'best'"):
        decide_sequence(TABLE, "abc", threshold=0.0, rule="best")
    with pytest.raises(ParameterError, match="min_frames"):
        decide_sequence(TABLE, "abc", threshold=0.0, min_frames=0)


def test_weighted_sum():
    for weights in ([-1.0, 1.0], [np.nan, 1.0]):
        with pytest.raises(ParameterError, match="weights: must be finite"):
            weighted_sum(TABLE, weights=weights)
    for shape in ((3,), (2, 2), ()):
        with pytest.raises(ParameterError, match="does not fit"):
            weighted_sum(TABLE, weights=np.ones(shape))


def test_linear_llr():
    good = {"weights": (1, 1), "centres": (0, 0), "scales": (1, 1), "bias": 0.0}
    for bad in ({"weights": (1,)}, {"centres": (0, 0, 0)}, {"scales": 1.0}):
        with pytest.raises(ParameterError, match="one for each of 2 heads"):
            linear_llr(TABLE, **{**good, **bad})
    for bad in ({"scales": (1, 0)}, {"bias": np.nan}, {"weights": (1, np.inf)}):
        with pytest.raises(ParameterError, match="finite, scales > 0"):
            linear_llr(TABLE, **{**good, **bad})


def test_llr_fusion():
    X, y = np.arange(8.0).reshape(4, 2), [0, 1, 0, 1]
    with pytest.raises(ParameterError, match="shrinkage"):
        LlrFusion(shrinkage=-1.0).fit(X, y)
    with pytest.raises(ParameterError, match="infinity"):
        LlrFusion().fit(np.where(X == 3, np.inf, X), y)
    with pytest.raises(ParameterError, match="infinity"):
        LlrFusion().fit(X, y).decision_function(X + np.inf)
    with pytest.raises(ParameterError, match="features"):
        LlrFusion().fit(X, y).decision_function(X[:, :1])
    with pytest.raises(ParameterError, match="binary"):
        LlrFusion().fit(X, [0, 1, 2, 0])
    with pytest.raises(DegenerateError, match="one class"):
        LlrFusion().fit(X, [1, 1, 1, 1])
    with pytest.raises(DegenerateError, match="no scores of one kind"):
        LlrFusion().fit(np.where((X == 2) | (X == 6), np.nan, X), y)


def test_sequential():
    with pytest.raises(ParameterError, match="llr"):
        sequential(TABLE, "ab")
    for bad, name in (
        ({"fpir": 0.0}, "fpir"),
        ({"fnir": 0.5}, "fnir"),
        ({"correlation": 1.1}, "correlation"),
        ({"min_frames": 0}, "min_frames"),
    ):
        with pytest.raises(ParameterError, match=name):
            sequential(TABLE, "abc", **bad)


def test_folds():
    rng = np.random.default_rng(0)
    for folds in (1, 3):
        with pytest.raises(ParameterError, match="folds"):
            people_folds(["a", "b", "a"], folds=folds, rng=rng)
    with pytest.raises(ParameterError, match="does not fit"):
        held_out_rates(TABLE, ["a", "b"], ["a", "b"], fmr=0.1, rng=rng)
    with pytest.raises(ParameterError, match="cannot be shown"):
        held_out_rates(np.eye(6), range(6), range(6), fmr=0.01, rng=rng, folds=2)
