"""Against scikit-learn's own implementations."""

import numpy as np
from sklearn import decomposition
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from rangeface.classify import PCA, FisherfaceLDA


def samples(pixels: int):
    rng = np.random.default_rng(11)
    X = np.repeat(rng.standard_normal((6, pixels)), 8, axis=0)
    return X + 0.3 * rng.standard_normal(X.shape), np.repeat(np.arange(6), 8)


def test_pca():
    X, _ = samples(100)
    theirs = decomposition.PCA(10, svd_solver="full").fit(X)
    ours = PCA(10).fit(X)
    np.testing.assert_allclose(ours.eigenvalues_, theirs.explained_variance_, rtol=1e-4)
    np.testing.assert_allclose(np.abs(ours.transform(X)), np.abs(theirs.transform(X)), atol=2e-3)


def test_lda_where_nothing_is_reduced():
    X, y = samples(12)  # 48 samples − 6 people > 12 pixels: PCA keeps all
    ours = FisherfaceLDA().fit(X, y)
    theirs = LinearDiscriminantAnalysis(solver="svd").fit(X, y)
    # theirs divides the within scatter by N, ours by its N − C degrees of freedom
    a, b = ours.transform(X), theirs.transform(X) * np.sqrt(42 / 48)
    np.testing.assert_allclose(np.abs(a), np.abs(b), rtol=1e-3, atol=1e-3)
