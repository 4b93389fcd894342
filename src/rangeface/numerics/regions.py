"""Covariance descriptors of image regions, in the log-Euclidean plane."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError, ParameterError

Float32: TypeAlias = NDArray[np.float32]
Float64: TypeAlias = NDArray[np.float64]


def block_covariance(
    features: ArrayLike, *, blocks: tuple[int, int], regularisation: float = 1e-3
) -> Float32:
    r"""Logarithms of the covariance matrices of a feature image's blocks.

    .. math:: v_b = \mathrm{vec}\, \log(C_b + ε I), \qquad
              \|v_a - v_b\| = \|\log C_a - \log C_b\|_F

    Parameters
    ----------
    features : (H, W, d) array_like
        d ≥ 1 features of a pixel, in comparable units, NaN where invalid.
    blocks : tuple of int
        Rows and columns of the grid of blocks, each ≥ 1.
    regularisation : float
        ε > 0, keeps the logarithm finite.

    Returns
    -------
    (rows · columns · d (d+1) / 2,) float32
        Upper triangles, off-diagonal entries times √2, so that Euclidean distance is the
        log-Euclidean one. A block with fewer than d + 1 valid pixels has the mean of the others.

    Raises
    ------
    ParameterError
        A block would be smaller than d + 1 pixels, or ε is not positive.
    DegenerateError
        No block has enough valid pixels.

    References
    ----------
    O. Tuzel, F. Porikli, P. Meer, ECCV 2006, doi:10.1007/11744047_45 (the descriptor);
    V. Arsigny et al., Magnetic Resonance in Medicine 56(2), 2006, doi:10.1002/mrm.20965 (the
    metric).

    Examples
    --------
    >>> x = np.array([[[-1.0], [1.0], [-1.0], [1.0]]])
    >>> block_covariance(x, blocks=(1, 1)).round(2)  # log(4/3 + ε)
    array([0.29], dtype=float32)
    """
    f = np.asarray(features, np.float64)
    height, width, d = f.shape
    rows, columns = blocks
    if min(blocks) < 1 or (height // rows) * (width // columns) < d + 1:
        raise ParameterError(
            f"blocks: {rows} × {columns} blocks of {height} × {width} px are too small"
        )
    if not regularisation > 0:
        raise ParameterError(f"regularisation: must be > 0, got {regularisation}")
    vectors = [
        _log_covariance(block, regularisation)
        for band in np.array_split(f, rows, axis=0)
        for block in np.array_split(band, columns, axis=1)
    ]
    known = [v for v in vectors if v is not None]
    if not known:
        raise DegenerateError("image: no block has enough valid pixels for a covariance")
    mean = np.mean(known, axis=0)
    return np.concatenate([mean if v is None else v for v in vectors]).astype(np.float32)


def _log_covariance(block: Float64, regularisation: float) -> Float64 | None:
    d = block.shape[-1]
    samples = block.reshape(-1, d)
    samples = samples[np.isfinite(samples).all(axis=1)]
    if len(samples) < d + 1:
        return None
    covariance = np.atleast_2d(np.cov(samples.T))
    values, vectors = np.linalg.eigh(covariance)
    logarithm = (vectors * np.log(np.maximum(values, 0.0) + regularisation)) @ vectors.T
    row, column = np.triu_indices(d)
    return np.asarray(logarithm[row, column] * np.where(row == column, 1.0, np.sqrt(2.0)))
