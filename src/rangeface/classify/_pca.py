"""Principal component analysis."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh

from rangeface.classify._base import Float32, LinearProjection, check_count
from rangeface.classify._span import oriented
from rangeface.errors import DegenerateError


class PCA(LinearProjection):
    r"""Principal component analysis (eigenfaces).

    .. math::
        W_{PCA} = \arg\max_W |W^T S_T W|, \quad
        S_T = \sum_k (x_k - μ)(x_k - μ)^T, \quad y_k = W_{PCA}^T (x_k - μ)
        \qquad (3.9–3.11)

    Parameters
    ----------
    n_components : int, optional
        Number of eigenvectors, ≥ 1; at most the rank of the samples are kept. None: all.
    metric : {"euclidean", "cosine"}
        Similarity of two projections: negative distance, or cosine.

    Attributes
    ----------
    mean_ : (m,) float32
    components_ : (n_components_, m) float32
        Orthonormal rows, largest eigenvalue first.
    eigenvalues_ : (n_components_,) float32
        Of S_T / (N − 1): the variances of the components.
    n_components_ : int

    Raises
    ------
    ParameterError
        A parameter is out of range, or a sample is not finite.
    DegenerateError
        One sample only, or all are alike.

    Notes
    -----
    With fewer samples than pixels the eigenvectors come from the N × N Gram matrix, X_c X_cᵀ:
    O(N² m + N³). (3.11) as printed omits −μ; it shifts all projections alike.

    References
    ----------
    M. Turk, A. Pentland, J. Cogn. Neurosci. 3(1), 1991, doi:10.1162/jocn.1991.3.1.71.

    Examples
    --------
    >>> X = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]])
    >>> PCA().fit(X).transform(X).ravel()
    array([-2.,  0.,  2.], dtype=float32)
    """

    eigenvalues_: Float32

    def __init__(
        self,
        n_components: int | None = None,
        *,
        metric: str = "euclidean",
    ) -> None:
        self.n_components = n_components
        self.metric = metric

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Find the components of samples X (N, m) in rows; y is ignored."""
        samples = self._samples(X)
        wanted = min(check_count("n_components", self.n_components), *samples.shape)
        mean = samples.mean(axis=0, dtype=np.float64).astype(np.float32)
        Xc = samples.astype(np.float32) - mean
        few = len(Xc) <= Xc.shape[1]
        S = Xc @ Xc.T if few else Xc.T @ Xc
        values, vectors = eigh(S, subset_by_index=(len(S) - wanted, len(S) - 1))
        values, vectors = values[::-1], vectors[:, ::-1]
        # beyond this, float32 sums leave rounding only
        kept = values > len(S) * np.finfo(np.float32).eps * np.abs(S).max()
        if len(Xc) < 2 or not kept.any() or np.ptp(Xc, axis=0).max() == 0:
            raise DegenerateError(f"PCA: all samples are alike (n_samples = {len(Xc)})")
        values, vectors = values[kept], vectors[:, kept]
        W = (vectors / np.sqrt(values)).T @ Xc if few else vectors.T
        self.eigenvalues_ = np.asarray(values / (len(Xc) - 1), dtype=np.float32)
        return self._keep(mean, oriented(W))
