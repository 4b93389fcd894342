"""Modified linear discriminant analysis."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigh

from rangeface.classify._base import Float32, LinearProjection, SupervisedTags, check_count
from rangeface.classify._span import oriented, scatter_between, span
from rangeface.errors import ParameterError


class MLDA(SupervisedTags, LinearProjection):
    r"""Modified linear discriminant analysis: the difference of scatters, not their quotient.

    .. math:: W_{MLDA} = \arg\max_W \operatorname{tr} W^T (S_B - α S_W) W, \quad W^T W = I
        \qquad (3.15)

    Parameters
    ----------
    n_components : int, optional
        Number of eigenvectors, ≥ 1; only those of positive eigenvalue are kept. None: all.
    alpha : float
        Weight α ≥ 0 of the within-class scatter.
    metric : {"euclidean", "cosine"}
        Similarity of two projections: negative distance, or cosine.

    Attributes
    ----------
    mean_ : (m,) float32
    components_ : (n_components_, m) float32
        Orthonormal rows, largest eigenvalue first.
    eigenvalues_ : (n_components_,) float32
        Of S_B − α S_W.
    n_components_ : int
        At most C − 1.

    Raises
    ------
    ParameterError
        A parameter is out of range, or a sample is not finite.
    DegenerateError
        One class only, or all samples are alike.

    Notes
    -----
    The source maximises the determinant; for an indefinite matrix the eigenvectors of the
    largest eigenvalues do not, but they maximise the trace, which is meant. S_B − α S_W has at
    most C − 1 positive eigenvalues, whatever α; a direction of negative value tells people
    apart less than it scatters each of them, so more components than that are not given. Where
    none is positive (α too large for the data) the best single direction is kept. Solved in
    the span of the samples: O(N² m + N³).

    References
    ----------
    The criterion: H. Li, T. Jiang, K. Zhang, IEEE Trans. Neural Netw. 17(1), 2006,
    doi:10.1109/TNN.2005.860852 (maximum margin criterion).

    Examples
    --------
    Two people who differ along the first axis and scatter along the second:

    >>> X = [[0.0, 0.0], [0.0, 2.0], [4.0, 0.0], [4.0, 2.0]]
    >>> mlda = MLDA(alpha=6.0).fit(X, ["a", "a", "b", "b"])
    >>> mlda.n_components_, abs(mlda.components_).round(3)
    (1, array([[1., 0.]], dtype=float32))
    """

    eigenvalues_: Float32

    def __init__(
        self,
        n_components: int | None = None,
        *,
        alpha: float = 6.0,
        metric: str = "euclidean",
    ) -> None:
        self.n_components = n_components
        self.alpha = alpha
        self.metric = metric

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Find the components of samples X (N, m) in rows, of people y (N,)."""
        samples, labels = self._samples_and_labels(X, y)
        if not (np.isfinite(self.alpha) and self.alpha >= 0):
            raise ParameterError(f"alpha: must be ≥ 0, got {self.alpha}")
        wanted = check_count("n_components", self.n_components)
        space = span(samples, dtype=np.float32)
        values, vectors = _top(
            _criterion(space.coordinates, labels, self.alpha), min(wanted, labels.max())
        )
        kept = np.maximum(1, np.count_nonzero(values > 0))
        self.eigenvalues_ = np.asarray(values[:kept], dtype=np.float32)
        return self._keep(space.mean, oriented(space.lift(vectors[:, :kept])))


def _criterion(Z: NDArray[Any], labels: NDArray[Any], alpha: float) -> NDArray[Any]:
    # S_T = S_B + S_W, so S_B − αS_W = (1 + α)S_B − αS_T: no pass over the deviations
    H_B = scatter_between(Z, labels)
    a = Z.dtype.type(alpha)
    return (1 + a) * (H_B.T @ H_B) - a * (Z.T @ Z)


def _top(S: NDArray[Any], count: int) -> tuple[NDArray[Any], NDArray[Any]]:
    count = min(count, len(S))
    values, vectors = eigh(
        S, subset_by_index=(len(S) - count, len(S) - 1), overwrite_a=True, check_finite=False
    )
    return values[::-1], vectors[:, ::-1]
