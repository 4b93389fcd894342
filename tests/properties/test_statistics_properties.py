"""What intervals and tests promise, checked by counting."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from rangeface.numerics.statistics import (
    bootstrap_over_groups,
    clopper_pearson,
    holm,
    mcnemar,
    permutation_test,
    wilson,
)


@given(st.integers(1, 400).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
@settings(deadline=None)
def test_intervals_hold_the_rate_and_mirror(case):
    k, n = case
    for interval in (wilson, clopper_pearson):
        low, high = interval(k, n)
        assert 0 <= low <= k / n <= high <= 1
        np.testing.assert_allclose(interval(n - k, n), (1 - high, 1 - low), atol=1e-9)
    # the exact interval is the wider one but for tails of one case
    assert np.diff(clopper_pearson(k, n))[0] >= 0.9 * np.diff(wilson(k, n))[0]


@pytest.mark.parametrize("p", [0.02, 0.3, 0.5])
@pytest.mark.parametrize("n", [24, 60, 126])
def test_clopper_pearson_covers_at_least_what_it_says(n, p):
    covered = [low <= p <= high for low, high in (clopper_pearson(k, n) for k in range(n + 1))]
    assert (binom.pmf(np.arange(n + 1), n, p) * covered).sum() >= 0.95


def test_drawing_people_is_wider_than_drawing_rows():
    """Rows of one person agree here, so there are only as many cases as people."""
    rng = np.random.default_rng(0)
    hits = np.repeat(rng.random(20) < 0.7, 30).astype(float)
    people = np.repeat(np.arange(20), 30)

    def mean(rows):
        return float(hits[rows].mean())

    by_person = np.diff(bootstrap_over_groups(mean, people, rng=np.random.default_rng(1)))
    by_row = np.diff(bootstrap_over_groups(mean, np.arange(600), rng=np.random.default_rng(1)))
    assert by_person[0] > 3 * by_row[0]


@given(st.lists(st.floats(0, 1), min_size=1, max_size=20))
def test_holm_never_lowers_a_p_value_nor_exceeds_bonferroni(p):
    corrected = holm(p)
    assert (corrected >= np.asarray(p)).all()
    assert (corrected <= np.minimum(1, len(p) * np.asarray(p)) + 1e-12).all()
    order = np.argsort(p, kind="stable")
    assert (np.diff(corrected[order]) >= 0).all()


def test_under_the_null_a_permutation_test_rejects_at_its_level():
    rng = np.random.default_rng(2)
    p = [
        permutation_test(*rng.standard_normal((2, 30)), rng=rng, resamples=199) for _ in range(300)
    ]
    assert np.mean(np.array(p) <= 0.05) < 0.09
    assert np.mean(p) == pytest.approx(0.5, abs=0.06)


def test_sides_can_be_swapped():
    rng = np.random.default_rng(3)
    a, b = rng.random((2, 50)) < [[0.8], [0.5]]
    assert mcnemar(a, b) == mcnemar(b, a)
    assert permutation_test(a, b, rng=np.random.default_rng(0)) == permutation_test(
        b, a, rng=np.random.default_rng(0)
    )
