"""Covariances of the surface in blocks of the image."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.classify._base import Float32, Matcher
from rangeface.errors import ParameterError

_FEATURES = 5  # x, y, value, and its two derivatives


class BlockCovariance(Matcher):
    r"""Describes each block of an image by how position, value and slope vary together.

    .. math::
        f = (x, y, z, z_x, z_y), \quad Σ_b = \operatorname{cov}_{b} f + ε I, \quad
        s(p, g) = -\Big(\sum_b \|\log Σ_b^p - \log Σ_b^g\|_F^2\Big)^{1/2}

    Parameters
    ----------
    image_shape : (int, int), optional
        Rows and columns of the image that a sample is; None: one row.
    grid : (int, int)
        Blocks down and across, ≥ 1; at most as many as pixels.
    ridge : float
        ε > 0; the features are brought to unit variance over the training samples first.

    Attributes
    ----------
    scale_ : (5,) float32
        Standard deviation of each feature over the training samples.

    Raises
    ------
    ParameterError
        A parameter is out of range, a sample is not finite, or not of that shape.

    Notes
    -----
    The log-Euclidean distance makes covariances a flat space, so `transform` gives their
    logarithms (15 numbers a block, off-diagonal ones times √2) and the distance is Euclidean.
    An offset of all values (a wrong distance) changes nothing.

    References
    ----------
    O. Tuzel, F. Porikli, P. Meer, ECCV 2006, doi:10.1007/11744047_45;
    V. Arsigny et al., Magn. Reson. Med. 56(2), 2006, doi:10.1002/mrm.20965.

    Examples
    --------
    >>> X = np.random.default_rng(0).random((4, 48))
    >>> matcher = BlockCovariance(image_shape=(8, 6), grid=(2, 2)).fit(X)
    >>> matcher.transform(X).shape
    (4, 60)
    """

    metric = "euclidean"
    scale_: Float32

    def __init__(
        self,
        *,
        image_shape: tuple[int, int] | None = None,
        grid: tuple[int, int] = (1, 1),
        ridge: float = 0.01,
    ) -> None:
        self.image_shape = image_shape
        self.grid = grid
        self.ridge = ridge

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Find the scale of the features of samples X (N, m) in rows; y is ignored."""
        if not (np.isfinite(self.ridge) and self.ridge > 0):
            raise ParameterError(f"ridge: must be > 0, got {self.ridge}")
        features = self._features(self._samples(X))
        deviation = features.std(axis=(0, 2, 3))
        self.scale_ = np.where(deviation > 0, deviation, 1.0).astype(np.float32)
        return self

    def transform(self, X: ArrayLike) -> Float32:
        """Logarithms of the blocks' covariances of samples (n, m): (n, 15 · blocks) float32.

        Raises
        ------
        ParameterError
            A value is not finite, or the width is not the fitted one.
        """
        features = self._features(self._fitted_samples(X)) / self.scale_[:, None, None]
        blocks = [
            block.reshape(*block.shape[:2], -1)
            for rows in np.array_split(features, self.grid[0], axis=2)
            for block in np.array_split(rows, self.grid[1], axis=3)
        ]
        return np.concatenate([self._log_covariance(block) for block in blocks], axis=1)

    def _features(self, samples: NDArray[Any]) -> NDArray[np.float64]:
        rows, cols = self.image_shape or (1, samples.shape[1])
        if rows * cols != samples.shape[1]:
            raise ParameterError(f"image_shape: {rows} × {cols} is not {samples.shape[1]} pixels")
        if not (1 <= self.grid[0] <= rows and 1 <= self.grid[1] <= cols):
            raise ParameterError(f"grid: {self.grid} does not fit {rows} × {cols} pixels")
        z = samples.reshape(-1, rows, cols).astype(np.float64)
        y, x = np.broadcast_arrays(np.arange(rows)[:, None], np.arange(cols)[None, :])
        planes = (np.broadcast_to(x, z.shape), np.broadcast_to(y, z.shape), z, *_slopes(z))
        return np.stack(planes, axis=1)

    def _log_covariance(self, block: NDArray[np.float64]) -> Float32:
        centred = block - block.mean(axis=2, keepdims=True)
        covariance = centred @ centred.transpose(0, 2, 1) / block.shape[2]
        values, U = np.linalg.eigh(covariance + self.ridge * np.eye(_FEATURES))
        logarithm = (U * np.log(np.maximum(values, self.ridge))[:, None, :]) @ U.transpose(0, 2, 1)
        i, j = np.triu_indices(_FEATURES)
        return np.asarray(logarithm[:, i, j] * np.where(i == j, 1.0, np.sqrt(2)), np.float32)


def _slopes(z: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    across = np.gradient(z, axis=2) if z.shape[2] > 1 else np.zeros_like(z)
    down = np.gradient(z, axis=1) if z.shape[1] > 1 else np.zeros_like(z)
    return across, down
