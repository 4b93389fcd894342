"""Fisherfaces: PCA, then linear discriminant analysis."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cholesky, eigh, solve_triangular, svd

from rangeface.classify._base import Float32, LinearProjection, SupervisedTags, check_count
from rangeface.classify._span import oriented, scatter_between, scatter_within, span
from rangeface.errors import DegenerateError


class FisherfaceLDA(SupervisedTags, LinearProjection):
    r"""Linear discriminant analysis after PCA to at most N − C dimensions.

    .. math:: W_{LDA} = \arg\max_W \frac{|W^T S_B W|}{|W^T S_W W|} \qquad (3.12–3.14)

    Parameters
    ----------
    n_components : int, optional
        Number of discriminant directions, ≥ 1; at most C − 1. None: C − 1.
    n_pca : int, optional
        Dimensions that PCA leaves, ≥ 1; at most N − C. None: N − C.
    metric : {"euclidean", "cosine"}
        Similarity of two projections: negative distance, or cosine.

    Attributes
    ----------
    mean_ : (m,) float32
    components_ : (n_components_, m) float32
        Rows with W S_W Wᵀ = (N − C) I, largest quotient first.
    quotients_ : (n_components_,) float32
        Between over within variance of each direction.
    n_components_, n_pca_ : int

    Raises
    ------
    ParameterError
        A parameter is out of range, or a sample is not finite.
    DegenerateError
        One class only, one sample a class, or no variation within any class.

    Notes
    -----
    The source prints m − C dimensions; Belhumeur et al. and the rank of S_W say N − C. The
    source's "LDA with 180 eigenvectors" is ``n_pca=180``.

    References
    ----------
    P. Belhumeur, J. Hespanha, D. Kriegman, IEEE TPAMI 19(7), 1997, doi:10.1109/34.598228.

    Examples
    --------
    >>> X = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [5.0, 0.0, 0.0], [5.0, 2.0, 0.0]]
    >>> lda = FisherfaceLDA().fit(X, [0, 0, 1, 1])
    >>> lda.n_pca_, lda.n_components_
    (2, 1)
    """

    quotients_: Float32
    n_pca_: int

    def __init__(
        self,
        n_components: int | None = None,
        *,
        n_pca: int | None = None,
        metric: str = "euclidean",
    ) -> None:
        self.n_components = n_components
        self.n_pca = n_pca
        self.metric = metric

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Find the directions of samples X (N, m) in rows, of people y (N,)."""
        samples, labels = self._samples_and_labels(X, y)
        wanted = check_count("n_components", self.n_components)
        freedom = len(samples) - (labels.max() + 1)
        if freedom < 1:
            raise DegenerateError("FisherfaceLDA: one sample a class; nothing varies within one")
        space = span(samples)
        basis = _principal(space.coordinates, min(check_count("n_pca", self.n_pca), freedom))
        Z = space.coordinates @ basis
        quotients, W = discriminants(
            scatter_between(Z, labels), scatter_within(Z, labels) / np.sqrt(freedom)
        )
        kept = min(wanted, labels.max(), len(quotients))
        self.n_pca_ = basis.shape[1]
        self.quotients_ = np.asarray(quotients[:kept], dtype=np.float32)
        return self._keep(space.mean, oriented(space.lift(basis @ W[:, :kept])))


def _principal(Z: NDArray[Any], count: int) -> NDArray[Any]:
    _, vectors = eigh(Z.T @ Z, driver="evd")
    return vectors[:, ::-1][:, :count]


def discriminants(
    H_B: NDArray[Any], H_W: NDArray[Any], *, ridge: float = 0.0
) -> tuple[NDArray[Any], NDArray[Any]]:
    r"""Directions that maximise wᵀS_B w / wᵀ(S_W + ρI)w, best first, with unit denominators.

    S_B = H_BᵀH_B has rank C − 1, so whitening S_W = L Lᵀ leaves a singular value problem of C
    rows. Directions in which nothing varies within a class, where the quotient is infinite,
    are held to a within variance of 1e-10 of the mean.
    """
    S_W = H_W.T @ H_W
    mean = float(S_W.diagonal().mean())
    if mean + ridge <= 1e-20 * np.square(H_B).sum():  # the rounding of duplicates
        raise DegenerateError("no class varies within itself; the quotient is undefined")
    L = cholesky(S_W + (ridge + 1e-10 * mean) * np.eye(len(S_W)), lower=True)
    _, roots, Vt = svd(solve_triangular(L, H_B.T, lower=True).T, full_matrices=False)
    return roots**2, solve_triangular(L, Vt.T, trans="T", lower=True)
