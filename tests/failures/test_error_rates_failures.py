"""What the error rates refuse."""

import numpy as np
import pytest

from rangeface.decide import threshold_at_fmr
from rangeface.errors import DegenerateError, ParameterError
from rangeface.evaluation.curves import cmc, det, same_person
from rangeface.evaluation.error_rates import Rate, eer, fnmr_at_fmr, mated_nonmated, rank_k
from rangeface.evaluation.open_set import fnir, fnir_at_fpir

SCORES = [[1.0, 0.0], [0.0, 1.0]]


def test_a_rate_of_nothing():
    with pytest.raises(DegenerateError, match="at least one case"):
        Rate.of(0, 0)


@pytest.mark.parametrize("measure", [same_person, mated_nonmated, rank_k, cmc])
def test_a_table_of_another_size(measure):
    with pytest.raises(ParameterError, match="does not fit"):
        measure(SCORES, ["a", "b"], ["a"])


@pytest.mark.parametrize("measure", [rank_k, cmc])
@pytest.mark.parametrize("stranger", ["A", "z"])
def test_a_stranger_in_a_closed_set(measure, stranger):
    with pytest.raises(ParameterError, match=f"'{stranger}' is not enrolled"):
        measure(SCORES, ["a", stranger], ["a", "b"])


def test_rank_zero():
    with pytest.raises(ParameterError, match="k:"):
        rank_k(SCORES, ["a", "b"], ["a", "b"], k=0)
    with pytest.raises(ParameterError, match="k:"):
        fnir(SCORES, ["a", "b"], ["a", "b"], 0.0, k=0)


@pytest.mark.parametrize("wanted", [0.0, 1.0, -0.1, np.nan])
def test_a_false_match_rate_outside_0_to_1(wanted):
    with pytest.raises(ParameterError, match="fmr"):
        threshold_at_fmr(np.arange(100), wanted)


def test_a_false_match_rate_that_so_few_comparisons_cannot_show():
    with pytest.raises(ParameterError, match=r"3 / 100 = 0.03"):
        threshold_at_fmr(np.arange(100), 0.029)
    with pytest.raises(ParameterError, match="cannot be shown"):
        fnmr_at_fmr([1.0], np.full(1000, np.nan), 0.1)
    with pytest.raises(ParameterError, match="cannot be shown"):
        fnir_at_fpir(SCORES, ["a", "b"], ["a", "b"], np.zeros((10, 2)), 0.1)


@pytest.mark.parametrize(("mated", "nonmated"), [([], [1.0]), ([1.0], []), ([1.0], [np.nan])])
def test_an_empty_side(mated, nonmated):
    with pytest.raises(DegenerateError, match="mated"):
        eer(mated, nonmated)
    with pytest.raises(DegenerateError, match="mated"):
        det(mated, nonmated)
