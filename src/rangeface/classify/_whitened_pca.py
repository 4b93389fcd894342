"""Principal components of unit variance, compared by their angle."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from rangeface.classify._pca import PCA


class WhitenedPCA(PCA):
    r"""Principal component analysis with components of unit variance, compared by cosine.

    .. math:: y = Λ^{-1/2} W_{PCA}^T (x - μ), \quad s(p, g) = \frac{p·g}{\|p\|\,\|g\|}

    Parameters
    ----------
    n_components : int, optional
        Number of eigenvectors, ≥ 1; at most the rank of the samples are kept. None: all.
    metric : {"cosine", "fisher-z", "euclidean"}
        Similarity of two projections.

    Attributes
    ----------
    mean_, components_, eigenvalues_, n_components_
        As in `PCA`; the rows of ``components_`` have length λ^(−1/2).

    Raises
    ------
    ParameterError
        A parameter is out of range, or a sample is not finite.
    DegenerateError
        One sample only, or all are alike.

    Notes
    -----
    With the Euclidean metric this is the Mahalanobis distance. The first components of range
    images are pose and distance, not identity; whitening takes their weight away, and gives it
    to noise if all components are kept.

    References
    ----------
    R. Beveridge et al., Mach. Vis. Appl. 16(2), 2005, doi:10.1007/s00138-004-0144-8
    (the "Mahalanobis cosine").

    Examples
    --------
    >>> X = np.array([[0.0, 0.0], [4.0, 0.0], [2.0, 1.0], [2.0, -1.0]])
    >>> WhitenedPCA().fit(X).transform([[6.0, 0.0]]).round(3)
    array([[2.449, 0.   ]], dtype=float32)
    """

    def __init__(self, n_components: int | None = None, *, metric: str = "cosine") -> None:
        super().__init__(n_components, metric=metric)

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Find the components of samples X (N, m) in rows; y is ignored."""
        super().fit(X)
        return self._keep(self.mean_, self.components_ / np.sqrt(self.eigenvalues_)[:, None])
