"""What decisions refuse."""

import numpy as np
import pytest

from rangeface.decide import (
    decide_sequence,
    majority_vote,
    open_set,
    per_subject,
    robust_norm,
    s_norm,
    sum_of_scores,
    t_norm,
    verify,
    z_norm,
)
from rangeface.errors import DegenerateError, ParameterError

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
