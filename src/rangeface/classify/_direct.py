"""Comparison of features as they are."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from rangeface.classify._base import Float32, Matcher


class Direct(Matcher):
    """Compares features as they are; nothing is learned.

    Parameters
    ----------
    metric : {"euclidean", "cosine"}
        Negative distance, or cosine. With log-covariances (``describe.block_covariance``) the
        Euclidean distance is the log-Euclidean distance of the covariances.

    Raises
    ------
    ParameterError
        A sample is not finite, or has another width than those that were fitted.

    Examples
    --------
    >>> matcher = Direct().fit([[0.0, 0.0]])
    >>> matcher.similarity(matcher.transform([[3.0, 4.0]]), [[0.0, 0.0]])
    array([[-5.]], dtype=float32)
    """

    def __init__(self, *, metric: str = "euclidean") -> None:
        self.metric = metric

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Check samples X (N, m) in rows; y is ignored."""
        self._samples(X)
        return self

    def transform(self, X: ArrayLike) -> Float32:
        """Samples (n, m) as they are: (n, m) float32."""
        return np.asarray(self._fitted_samples(X), dtype=np.float32)
