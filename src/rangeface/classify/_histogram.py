"""Matching of histograms."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.classify._base import Float32, Matcher
from rangeface.errors import ParameterError


class HistogramMatcher(Matcher):
    r"""Compares histograms as they are; nothing is learned.

    .. math::
        s_{χ²} = -\tfrac12 \sum_d \frac{(p_d - g_d)^2}{p_d + g_d}, \quad
        s_{intersection} = \sum_d \min(p_d, g_d)

    Parameters
    ----------
    blocks : int
        Number of histograms of equal length that stand one after the other in a sample, ≥ 1;
        each is brought to sum 1 / blocks.
    metric : {"chi-square", "intersection"}
        Kind of similarity.

    Raises
    ------
    ParameterError
        A value is negative or not finite, or the length is no multiple of `blocks`.

    Notes
    -----
    An empty histogram stays empty.

    References
    ----------
    T. Ahonen, A. Hadid, M. Pietikäinen, IEEE TPAMI 28(12), 2006, doi:10.1109/TPAMI.2006.244.

    Examples
    --------
    >>> matcher = HistogramMatcher(metric="intersection").fit([[1, 3], [2, 2]])
    >>> H = matcher.transform([[1, 3], [2, 2]])
    >>> matcher.similarity(H, H)
    array([[1.  , 0.75],
           [0.75, 1.  ]], dtype=float32)
    """

    def __init__(self, *, blocks: int = 1, metric: str = "chi-square") -> None:
        self.blocks = blocks
        self.metric = metric

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Check samples X (N, m) in rows; y is ignored."""
        self._counts(self._samples(X))
        return self

    def transform(self, X: ArrayLike) -> Float32:
        """Bring histograms (n, m) to unit sum: (n, m) float32.

        Raises
        ------
        ParameterError
            A value is negative or not finite, or the width is not the fitted one.
        """
        counts = self._counts(self._fitted_samples(X))
        sums = counts.sum(axis=2, keepdims=True)
        shares = counts / np.where(sums > 0, sums, 1.0) / self.blocks
        return np.asarray(shares.reshape(len(counts), -1), dtype=np.float32)

    def _counts(self, samples: NDArray[Any]) -> NDArray[np.float64]:
        if (samples < 0).any():
            raise ParameterError("HistogramMatcher: Negative values in data; counts are ≥ 0")
        if self.blocks < 1 or samples.shape[1] % self.blocks:
            raise ParameterError(
                f"blocks: {self.blocks} histograms do not fit a length of {samples.shape[1]}"
            )
        return samples.reshape(len(samples), self.blocks, -1).astype(np.float64)

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.positive_only = True
        return tags
