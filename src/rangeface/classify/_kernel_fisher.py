"""Kernel Fisher analysis."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve_triangular

from rangeface.classify._base import Float32, Matcher, SupervisedTags, check_count
from rangeface.classify._fisherface import discriminants
from rangeface.classify._regularized_lda import check_shrinkage
from rangeface.classify._span import gram_span, scatter_between, scatter_within
from rangeface.errors import DegenerateError, ParameterError


class KernelFisher(SupervisedTags, Matcher):
    r"""Linear discriminant analysis in the feature space of a Gaussian kernel.

    .. math:: k(x, x') = \exp(-γ \|x - x'\|^2)

    Parameters
    ----------
    n_components : int, optional
        Number of discriminant directions, ≥ 1; at most C − 1. None: C − 1.
    gamma : float, optional
        γ > 0, one over squared feature units. None: one over the median squared distance of the
        training samples.
    shrinkage : float
        0 … 1: as in `RegularizedLDA`, in feature space.
    metric : {"cosine", "fisher-z", "euclidean"}
        Similarity of two projections.

    Attributes
    ----------
    samples_ : (N, m) float32
        Training samples.
    dual_ : (N, n_components_) float32
        Weights of the kernel values.
    offset_ : (n_components_,) float32
    gamma_ : float
    n_components_ : int

    Raises
    ------
    ParameterError
        A parameter is out of range, or a sample is not finite.
    DegenerateError
        One class only, all samples alike, or no variation within any class.

    Notes
    -----
    The centred kernel matrix is the Gram matrix of the samples in feature space, so the same
    pivoted Cholesky factor that serves the linear methods gives coordinates here.

    References
    ----------
    G. Baudat, F. Anouar, Neural Comput. 12(10), 2000, doi:10.1162/089976600300014980.

    Examples
    --------
    Two rings that no line separates:

    >>> t = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    >>> ring = np.stack([np.cos(t), np.sin(t)], axis=1)
    >>> y = KernelFisher().fit(np.concatenate([ring, 3 * ring]), [0] * 12 + [1] * 12)
    >>> inner, outer = (y.transform(r * ring)[:, 0] for r in (1, 3))
    >>> bool(max(inner) < min(outer) or max(outer) < min(inner))
    True
    """

    samples_: Float32
    dual_: Float32
    offset_: Float32
    gamma_: float
    n_components_: int

    def __init__(
        self,
        n_components: int | None = None,
        *,
        gamma: float | None = None,
        shrinkage: float = 0.1,
        metric: str = "cosine",
    ) -> None:
        self.n_components = n_components
        self.gamma = gamma
        self.shrinkage = shrinkage
        self.metric = metric

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Find the directions of samples X (N, m) in rows, of people y (N,)."""
        samples, labels = self._samples_and_labels(X, y)
        shrinkage = check_shrinkage(self.shrinkage)
        wanted = check_count("n_components", self.n_components)
        distances = _squared_distances(samples, samples)
        self.gamma_ = self._width(distances)
        K = np.exp(-self.gamma_ * distances)
        column = K.mean(axis=0)
        Z, pivots, L = gram_span(K - column - column[:, None] + column.mean())
        H_W = scatter_within(Z, labels) / np.sqrt(max(1, len(Z) - (labels.max() + 1)))
        ridge = shrinkage * float(np.square(H_W).sum()) / Z.shape[1]
        quotients, W = discriminants(
            scatter_between(Z, labels), np.sqrt(1 - shrinkage) * H_W, ridge=ridge
        )
        kept = min(wanted, labels.max(), len(quotients))
        weights = solve_triangular(L, W[:, :kept], trans="T", lower=True)
        # y = Σ_p w_p k_c(x, x_p), with the centring of k_c multiplied out
        dual = np.tile(-weights.sum(axis=0) / len(K), (len(K), 1))
        dual[pivots] += weights
        self.samples_ = samples.astype(np.float32)
        self.dual_ = dual.astype(np.float32)
        self.offset_ = (column @ dual).astype(np.float32)
        self.n_components_ = kept
        return self

    def transform(self, X: ArrayLike) -> Float32:
        """Project samples.

        Parameters
        ----------
        X : (n, m) array_like
            Samples in rows, finite.

        Returns
        -------
        (n, n_components_) float32

        Raises
        ------
        ParameterError
            A value is not finite, or the width is not the fitted one.
        """
        K = np.exp(-self.gamma_ * _squared_distances(self._fitted_samples(X), self.samples_))
        return np.asarray(K @ self.dual_.astype(np.float64) - self.offset_, dtype=np.float32)

    def _width(self, distances: NDArray[Any]) -> float:
        if self.gamma is not None:
            if not (np.isfinite(self.gamma) and self.gamma > 0):
                raise ParameterError(f"gamma: must be > 0 or None, got {self.gamma}")
            return float(self.gamma)
        apart = distances[distances > 1e-10 * distances.max()]
        if apart.size == 0:
            raise DegenerateError("KernelFisher: the samples are all alike")
        return float(1.0 / np.median(apart))


def _squared_distances(A: NDArray[Any], B: NDArray[Any]) -> NDArray[np.float64]:
    a, b = A.astype(np.float64), B.astype(np.float64)
    centre = b.mean(axis=0)
    a, b = a - centre, b - centre
    squares = np.square(a).sum(axis=1)[:, None] + np.square(b).sum(axis=1) - 2 * (a @ b.T)
    return np.asarray(np.maximum(squares, 0.0))
