"""What every classifier keeps."""

import numpy as np
import pytest
from sklearn.utils.estimator_checks import check_estimator

from rangeface.classify import METHODS, fitted_state, restore

EVERY = pytest.mark.parametrize("kind", METHODS.values(), ids=METHODS)


def samples(people: int = 6, each: int = 4, pixels: int = 60):
    """Fewer samples than pixels; values ≥ 0 so that histograms are served too."""
    rng = np.random.default_rng(7)
    centres = rng.gamma(2.0, size=(people, pixels))
    X = np.abs(
        np.repeat(centres, each, axis=0) + 0.2 * rng.standard_normal((people * each, pixels))
    )
    return X.astype(np.float32), np.repeat([f"p{i}" for i in range(people)], each)


@EVERY
def test_scikit_learn_accepts_it(kind):
    check_estimator(kind(), on_skip=None)


@EVERY
def test_features_and_scores_are_finite_float32(kind):
    X, y = samples()
    matcher = kind().fit(X, y)
    features = matcher.transform(X)
    scores = matcher.similarity(features[:5], features)
    assert features.dtype == scores.dtype == np.float32
    assert features.shape[0] == len(X)
    assert scores.shape == (5, len(X))
    assert np.isfinite(features).all()
    assert np.isfinite(scores).all()


@EVERY
def test_nothing_is_more_like_a_probe_than_itself(kind):
    X, y = samples()
    matcher = kind().fit(X, y)
    features = matcher.transform(X)
    scores = matcher.similarity(features, features)
    assert (scores.diagonal() >= scores.max(axis=1) - 1e-4 * np.abs(scores).max()).all()


@pytest.mark.parametrize("kind", [k for name, k in METHODS.items() if name != "surface"])
def test_people_are_told_apart(kind):  # "surface" wants surfaces: test_classify_surface.py
    X, y = samples()
    matcher = kind().fit(X[::2], y[::2])
    scores = matcher.similarity(matcher.transform(X[1::2]), matcher.transform(X[::2]))
    assert (y[::2][scores.argmax(axis=1)] == y[1::2]).all()


@EVERY
def test_a_batch_is_its_rows(kind):
    X, y = samples()
    matcher = kind().fit(X, y)
    features = matcher.transform(X)
    alone = np.concatenate([matcher.transform(x[None]) for x in X])
    np.testing.assert_allclose(features, alone, rtol=1e-5, atol=1e-5 * np.abs(features).max())
    scores = matcher.similarity(features, features)
    one_by_one = np.concatenate([matcher.similarity(f[None], features) for f in features])
    np.testing.assert_allclose(scores, one_by_one, rtol=1e-5, atol=1e-5 * np.abs(scores).max())


@EVERY
def test_inputs_are_left_alone_and_fits_agree(kind):
    X, y = samples()
    before = X.copy()
    first, second = kind().fit(X, y), kind().fit(X, y)
    np.testing.assert_array_equal(first.transform(X), second.transform(X))
    np.testing.assert_array_equal(X, before)


@EVERY
def test_it_survives_being_taken_apart(kind):
    X, y = samples()
    matcher = kind().fit(X, y)
    state = fitted_state(matcher)
    for value in state.values():
        assert isinstance(value, int | float | str) or value.dtype != object
    again = restore(kind, matcher.get_params(), state)
    features = matcher.transform(X)
    np.testing.assert_array_equal(again.transform(X), features)
    np.testing.assert_array_equal(
        again.similarity(features, features), matcher.similarity(features, features)
    )
