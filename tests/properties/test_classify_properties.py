"""Theorems about the projections."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rangeface.classify import (
    MLDA,
    PCA,
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
from rangeface.classify._span import scatter_between, scatter_within, span
from rangeface.numerics.similarity import similarity

SEEDS = st.integers(0, 10_000)
FEW = settings(max_examples=25, deadline=None)


def draw(seed: int, people: int = 5, each: int = 4, pixels: int = 40):
    rng = np.random.default_rng(seed)
    X = np.repeat(rng.standard_normal((people, pixels)), each, axis=0)
    X += 0.5 * rng.standard_normal(X.shape)
    return X.astype(np.float32), np.repeat(np.arange(people), each)


def scatters(X, labels):
    H_B, H_W = (f(X.astype(float), labels) for f in (scatter_between, scatter_within))
    return H_B.T @ H_B, H_W.T @ H_W


@given(SEEDS)
@FEW
def test_total_scatter_is_between_plus_within(seed):
    """S_T = S_B + S_W (Duda, Hart, Stork, Pattern Classification, 2nd ed., eq. 4.112)."""
    X, labels = draw(seed)
    S_B, S_W = scatters(X, labels)
    Xc = X - X.mean(axis=0, dtype=float)
    np.testing.assert_allclose(S_B + S_W, Xc.T @ Xc, atol=1e-4)


@given(SEEDS, st.sampled_from([np.float32, np.float64]), st.sampled_from([8, 40]))
@FEW
def test_a_span_is_an_isometry(seed, dtype, pixels):
    """Coordinates in an orthonormal basis keep all inner products of centred samples."""
    X, _ = draw(seed, pixels=pixels)
    space = span(X, dtype=dtype)
    Xc = X - X.mean(axis=0, dtype=float)
    Z = space.coordinates
    np.testing.assert_allclose(Z @ Z.T, Xc @ Xc.T, atol=1e-3)
    V = space.lift(np.eye(Z.shape[1], dtype=dtype))
    np.testing.assert_allclose(V @ V.T, np.eye(len(V)), atol=1e-3)
    np.testing.assert_allclose(Z @ V, Xc, atol=1e-3)


@given(SEEDS)
@FEW
def test_pca_of_all_components_keeps_distances(seed):
    X, _ = draw(seed)
    Y = PCA().fit(X).transform(X)
    np.testing.assert_allclose(similarity(Y, Y), similarity(X, X), atol=1e-3)


@given(SEEDS)
@FEW
def test_whitened_components_have_unit_variance(seed):
    X, _ = draw(seed)
    Y = WhitenedPCA(6).fit(X).transform(X)
    np.testing.assert_allclose(np.cov(Y.T), np.eye(6), atol=1e-4)


@given(SEEDS, st.floats(0.0, 4.0))
@FEW
def test_mlda_components_are_orthonormal_and_at_most_c_minus_1(seed, alpha):
    X, labels = draw(seed)
    mlda = MLDA(alpha=alpha).fit(X, labels)
    W = mlda.components_
    assert mlda.n_components_ == len(W) <= 4
    np.testing.assert_allclose(W @ W.T, np.eye(len(W)), atol=1e-4)


@given(SEEDS, st.floats(0.0, 4.0))
@FEW
def test_mlda_keeps_exactly_the_positive_part_of_the_full_problem(seed, alpha):
    """The span loses nothing: its eigenpairs are those of the m × m matrix S_B − αS_W."""
    X, labels = draw(seed)
    S_B, S_W = scatters(X, labels)
    values, vectors = np.linalg.eigh(S_B - alpha * S_W)
    mlda = MLDA(alpha=alpha).fit(X, labels)
    count = max(1, np.count_nonzero(values > 1e-4 * values[-1]))
    assert mlda.n_components_ == count
    np.testing.assert_allclose(
        mlda.eigenvalues_, values[::-1][:count], rtol=1e-3, atol=1e-3 * values[-1]
    )
    if values[-2] < 0.9 * values[-1]:
        assert abs(mlda.components_[0] @ vectors[:, -1]) > 0.99


@given(SEEDS)
@FEW
def test_fisherfaces_whiten_the_within_scatter(seed):
    """W S_W Wᵀ = (N − C) I by construction of the quotient's eigenvectors."""
    X, labels = draw(seed)
    lda = FisherfaceLDA().fit(X, labels)
    Y = lda.transform(X).astype(float)
    H_W = scatter_within(Y, labels)
    # float32 vectors of a scatter that is nearly singular
    np.testing.assert_allclose(H_W.T @ H_W / (len(X) - 5), np.eye(4), atol=5e-3)
    H_B = scatter_between(Y, labels)
    np.testing.assert_allclose(
        (H_B.T @ H_B).diagonal(), lda.quotients_, rtol=1e-3, atol=1e-3 * lda.quotients_[0]
    )


@given(SEEDS)
@FEW
def test_neither_order_nor_offset_of_the_samples_matters(seed):
    X, labels = draw(seed)
    shuffle = np.random.default_rng(seed).permutation(len(X))
    for kind in (PCA, MLDA, FisherfaceLDA, RegularizedLDA):
        Y = kind(3).fit(X, labels).transform(X)
        other = kind(3).fit(X[shuffle] + 2.0, labels[shuffle]).transform(X + 2.0)
        scores = similarity(Y, Y)
        tolerance = 1e-3 * np.abs(scores).max()
        np.testing.assert_allclose(scores, similarity(other, other), atol=tolerance)


@pytest.mark.parametrize(
    "metric", ["euclidean", "cosine", "fisher-z", "chi-square", "intersection"]
)
def test_the_kernels_say_what_numpy_says(metric):
    rng = np.random.default_rng(0)
    P, G = rng.random((7, 33)), rng.random((11, 33))
    P[2] = G[4] = 0.0
    p, g = P[:, None], G[None]
    with np.errstate(invalid="ignore"):
        cosine = (p * g).sum(2) / np.linalg.norm(p, axis=2) / np.linalg.norm(g, axis=2)
        expected = {
            "euclidean": -np.linalg.norm(p - g, axis=2),
            "cosine": np.nan_to_num(cosine),
            "fisher-z": np.arctanh(np.nan_to_num(cosine)),
            "chi-square": -0.5 * np.nan_to_num((p - g) ** 2 / (p + g)).sum(2),
            "intersection": np.minimum(p, g).sum(2),
        }[metric]
    np.testing.assert_allclose(similarity(P, G, metric=metric), expected, atol=1e-5)


def test_fisher_z_of_the_same_vector_is_finite():
    X = np.random.default_rng(1).normal(size=(5, 20))
    scores = similarity(X, X, metric="fisher-z")
    assert np.isfinite(scores).all()
    assert (scores.argmax(axis=1) == np.arange(5)).all()
    assert similarity(X, -X, metric="fisher-z").diagonal().max() == -scores.diagonal().min()


@given(SEEDS)
@FEW
def test_regularised_analysis_whitens_the_shrunk_within_scatter(seed):
    X, labels = draw(seed, pixels=8)
    W = RegularizedLDA(shrinkage=0.3).fit(X, labels).components_.astype(float)
    _, S_W = scatters(X, labels)
    S = 0.7 * S_W + 0.3 * np.trace(S_W) / 8 * np.eye(8)
    np.testing.assert_allclose(W @ S @ W.T / (len(X) - 5), np.eye(4), atol=1e-3)


@given(SEEDS)
@FEW
def test_a_wide_gaussian_kernel_is_linear(seed):
    """exp(−γd²) → 1 − γd² for γ → 0, and centring leaves 2γ⟨x, x'⟩."""
    X, labels = draw(seed)
    linear = RegularizedLDA(shrinkage=0.3).fit(X, labels).transform(X)
    kernel = KernelFisher(shrinkage=0.3, gamma=1e-5).fit(X, labels).transform(X)
    for a, b in ((linear, linear), (kernel, kernel)):
        np.testing.assert_allclose(similarity(a, b, metric="cosine").diagonal(), 1, atol=1e-4)
    np.testing.assert_allclose(
        similarity(linear, linear, metric="cosine"),
        similarity(kernel, kernel, metric="cosine"),
        atol=0.05,
    )


@given(SEEDS)
@FEW
def test_a_linear_machine_separates_what_can_be_separated(seed):
    X, labels = draw(seed, people=3)
    Y = SVM(penalty=1e3).fit(X, labels).transform(X)
    assert (Y.argmax(axis=1) == labels).all()


@given(SEEDS)
@FEW
def test_collaborative_codes_solve_the_ridge_problem(seed):
    X, labels = draw(seed)
    crc = CollaborativeRepresentation(regularization=0.1).fit(X)
    G, P = crc.transform(X), crc.transform(X + 0.3)
    g, p = G.astype(float), P.astype(float)
    alpha = np.linalg.solve(g @ g.T + 0.1 * np.eye(len(g)), g @ p.T).T
    for person in range(5):
        rows = labels == person
        residual = np.linalg.norm(p - alpha[:, rows] @ g[rows], axis=1)
        expected = -residual / np.linalg.norm(alpha[:, rows], axis=1)
        scores = crc.similarity(P, G, owners=labels)
        for column in np.flatnonzero(rows):
            np.testing.assert_allclose(scores[:, column], expected, rtol=1e-4)


@given(SEEDS)
@FEW
def test_intersection_is_one_minus_half_the_cityblock_distance(seed):
    """For histograms of sum 1 (Swain and Ballard, IJCV 7(1), 1991)."""
    H = np.random.default_rng(seed).random((5, 24))
    matcher = HistogramMatcher(blocks=3, metric="intersection").fit(H)
    Y = matcher.transform(H).astype(float)
    np.testing.assert_allclose(Y.reshape(5, 3, 8).sum(axis=2), 1 / 3, rtol=1e-6)
    cityblock = np.abs(Y[:, None] - Y[None]).sum(axis=2)
    np.testing.assert_allclose(matcher.similarity(Y, Y), 1 - cityblock / 2, atol=1e-6)


@given(SEEDS, st.floats(0.1, 10), st.floats(-5, 5))
@FEW
def test_pearson_is_numpys_and_sees_neither_gain_nor_offset(seed, gain, offset):
    X = np.random.default_rng(seed).standard_normal((4, 25))
    for matcher in (PearsonMatcher(), WarpedPearsonMatcher(band=0)):
        matcher.fit(X)
        scores = matcher.similarity(matcher.transform(gain * X + offset), matcher.transform(X))
        np.testing.assert_allclose(scores, np.corrcoef(X), atol=1e-4)


@given(SEEDS, st.integers(0, 5))
@FEW
def test_a_shift_within_the_tolerance_costs_nothing(seed, shift):
    wide = np.random.default_rng(seed).standard_normal((1, 40))
    matcher = PearsonMatcher(max_shift=5).fit(wide[:, :30])
    P, G = matcher.transform(wide[:, :30]), matcher.transform(wide[:, shift : 30 + shift])
    assert matcher.similarity(P, G)[0, 0] > 1 - 1e-4


@given(SEEDS)
@FEW
def test_warping_undoes_a_stretch(seed):
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, 60)
    profile = np.sin(2 * np.pi * (1.5 * t + rng.random())) + t
    stretched = np.interp(t + 0.04 * np.sin(np.pi * t), t, profile)
    matcher = WarpedPearsonMatcher(band=6).fit(profile[None])
    plain = PearsonMatcher().fit(profile[None])
    P, G = matcher.transform(stretched[None]), matcher.transform(profile[None])
    assert matcher.similarity(P, G)[0, 0] > max(0.995, plain.similarity(P, G)[0, 0])
