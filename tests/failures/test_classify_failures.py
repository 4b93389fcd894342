"""Training sets and parameters that no classifier can use; and those that it must survive."""

import numpy as np
import pytest

from rangeface.classify import (
    METHODS,
    MLDA,
    PCA,
    SUPERVISED,
    SVM,
    CollaborativeRepresentation,
    FisherfaceLDA,
    HistogramMatcher,
    KernelFisher,
    PearsonMatcher,
    RegularizedLDA,
    WarpedPearsonMatcher,
    WhitenedPCA,
)
from rangeface.errors import DegenerateError, ParameterError, RangeFaceError
from rangeface.numerics.similarity import similarity

rng = np.random.default_rng(3)
NOISE = rng.random((12, 30)).astype(np.float32)
LABELS = np.repeat([0, 1, 2], 4)

DEGENERATE = {
    "one person": (NOISE, np.zeros(12, int)),
    "one sample": (NOISE[:1], [0]),
    "one sample each": (NOISE[:3], [0, 1, 2]),
    "all samples alike": (np.ones((12, 30)), LABELS),
    "duplicates": (np.repeat(NOISE[:3], 4, axis=0), LABELS),
    "duplicates across people": (np.tile(NOISE[:4], (3, 1)), LABELS),
    "constant pixels": (np.where(np.arange(30) < 25, 1.0, NOISE), LABELS),
    "one pixel": (NOISE[:, :1], LABELS),
    "two samples": (NOISE[:2], [0, 1]),
    "more samples than pixels": (NOISE[:, :5], LABELS),
    "uneven classes": (NOISE, [0] * 10 + [1, 2]),
    "huge": (NOISE * 1e15, LABELS),
    "tiny": (NOISE * 1e-15, LABELS),
}


@pytest.mark.parametrize("case", DEGENERATE)
@pytest.mark.parametrize("kind", METHODS.values(), ids=METHODS)
def test_a_degenerate_training_set_gives_a_finite_model_or_a_typed_error(kind, case):
    X, y = DEGENERATE[case]
    try:
        matcher = kind().fit(X, y)
        features = matcher.transform(X)
        scores = matcher.similarity(features, features)
    except RangeFaceError:
        return
    assert np.isfinite(features).all()
    assert np.isfinite(scores).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("kind", METHODS.values(), ids=METHODS)
def test_a_value_that_is_not_finite_is_refused(kind, bad):
    X = NOISE.copy()
    X[3, 4] = bad
    with pytest.raises(ParameterError, match=kind.__name__):
        kind().fit(X, LABELS)
    with pytest.raises(ParameterError, match=kind.__name__):
        kind().fit(NOISE, LABELS).transform(X)


@pytest.mark.parametrize("kind", METHODS.values(), ids=METHODS)
def test_another_width_is_refused(kind):
    with pytest.raises(ParameterError, match="features"):
        kind().fit(NOISE, LABELS).transform(NOISE[:, :9])


@pytest.mark.parametrize(
    ("matcher", "name"),
    [
        (PCA(0), "n_components"),
        (PCA(1.5), "n_components"),
        (MLDA(-1), "n_components"),
        (MLDA(alpha=-1), "alpha"),
        (MLDA(alpha=np.nan), "alpha"),
        (FisherfaceLDA(0), "n_components"),
        (FisherfaceLDA(n_pca=0), "n_pca"),
        (WhitenedPCA(0), "n_components"),
        (RegularizedLDA(0), "n_components"),
        (RegularizedLDA(shrinkage=0.0), "shrinkage"),
        (RegularizedLDA(shrinkage=1.1), "shrinkage"),
        (KernelFisher(0), "n_components"),
        (KernelFisher(gamma=0.0), "gamma"),
        (KernelFisher(shrinkage=0.0), "shrinkage"),
        (CollaborativeRepresentation(0), "n_components"),
        (CollaborativeRepresentation(regularization=0.0), "regularization"),
        (SVM(penalty=0.0), "penalty"),
        (HistogramMatcher(blocks=0), "blocks"),
        (HistogramMatcher(blocks=7), "blocks"),
        (PearsonMatcher(max_shift=-1), "max_shift"),
        (WarpedPearsonMatcher(band=-1), "band"),
    ],
)
def test_a_parameter_out_of_range_is_named(matcher, name):
    with pytest.raises(ParameterError, match=name):
        matcher.fit(NOISE, LABELS)


@pytest.mark.parametrize("kind", [METHODS[name] for name in sorted(SUPERVISED)])
def test_one_person_is_too_few(kind):
    with pytest.raises(DegenerateError, match="one class"):
        kind().fit(NOISE, np.zeros(12))


@pytest.mark.parametrize(
    "kind",
    [PCA, WhitenedPCA, CollaborativeRepresentation, *(METHODS[n] for n in sorted(SUPERVISED))],
)
def test_samples_that_are_all_alike_are_refused(kind):
    with pytest.raises(DegenerateError, match="alike"):
        kind().fit(np.full((12, 30), 0.1), LABELS)


@pytest.mark.parametrize("kind", [FisherfaceLDA, RegularizedLDA, KernelFisher])
def test_a_quotient_needs_variation_within_people(kind):
    with pytest.raises(DegenerateError, match="varies within"):
        kind().fit(np.repeat(NOISE[:3], 4, axis=0), LABELS)


def test_fisherfaces_need_two_samples_of_somebody():
    with pytest.raises(DegenerateError, match="one sample a class"):
        FisherfaceLDA().fit(NOISE[:3], [0, 1, 2])


def test_counts_are_not_negative():
    with pytest.raises(ParameterError, match="Negative"):
        HistogramMatcher().fit(NOISE - 0.5)
    with pytest.raises(ParameterError, match="Negative"):
        HistogramMatcher().fit(NOISE).transform(NOISE - 0.5)


def test_a_machine_that_does_not_converge_says_so(monkeypatch):
    monkeypatch.setattr("rangeface.classify._svm._MAX_ITERATIONS", 1)
    with pytest.raises(DegenerateError, match="does not converge"):
        SVM(penalty=1e6).fit(NOISE, LABELS)


def test_similarity_refuses_an_unknown_metric_and_rows_of_two_lengths():
    with pytest.raises(ParameterError, match=r"metric: unknown 'l7'.*euclidean"):
        similarity(NOISE, NOISE, metric="l7")
    with pytest.raises(ParameterError, match="one length"):
        similarity(NOISE, NOISE[:, :9])
    matcher = PCA(metric="l7").fit(NOISE)
    with pytest.raises(ParameterError, match="metric"):
        matcher.similarity(NOISE, NOISE)
