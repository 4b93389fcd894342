"""Histograms of labels by region, and the distances that compare them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError, ParameterError

Float32: TypeAlias = NDArray[np.float32]
Float64: TypeAlias = NDArray[np.float64]


def regional(
    labels: ArrayLike, valid: ArrayLike, *, count: int, regions: tuple[int, int]
) -> Float32:
    """Relative frequencies of labels in every region of a grid.

    Parameters
    ----------
    labels : (H, W) array_like
        Whole numbers 0 … count − 1.
    valid : (H, W) array_like of bool
        Which pixels are counted.
    count : int
        Number of labels.
    regions : tuple of int
        Rows and columns of the grid, each ≥ 1 and no more than pixels.

    Returns
    -------
    (rows · columns · count,) float32
        Region by region, each summing to 1. A region without a valid pixel has the
        frequencies of the whole image.

    Raises
    ------
    ParameterError
        The grid has no cell, or cells smaller than a pixel.
    DegenerateError
        No pixel is valid.

    References
    ----------
    T. Ahonen, A. Hadid, M. Pietikäinen, IEEE TPAMI 28(12), 2006, doi:10.1109/TPAMI.2006.244.

    Examples
    --------
    >>> regional([[0, 0, 1, 2]], np.ones((1, 4)), count=3, regions=(1, 2))
    array([1. , 0. , 0. , 0. , 0.5, 0.5], dtype=float32)
    """
    codes, mask = np.asarray(labels, np.int64), np.asarray(valid, bool)
    rows, columns = regions
    if not (1 <= rows <= codes.shape[0] and 1 <= columns <= codes.shape[1]):
        raise ParameterError(f"regions: a grid {rows} × {columns} does not fit {codes.shape} px")
    if not mask.any():
        raise DegenerateError("image: no valid pixels")
    row = np.arange(codes.shape[0]) * rows // codes.shape[0]
    column = np.arange(codes.shape[1]) * columns // codes.shape[1]
    cell = row[:, None] * columns + column
    bins = np.bincount((cell * count + codes)[mask], minlength=rows * columns * count)
    frequency = bins.reshape(-1, count).astype(np.float64)
    total = frequency.sum(axis=1, keepdims=True)
    whole = frequency.sum(axis=0) / frequency.sum()
    return np.where(total > 0, frequency / np.maximum(total, 1), whole).astype(np.float32).ravel()


def chi_square(first: ArrayLike, second: ArrayLike) -> Float64:
    r"""χ² distance between all pairs of histograms.

    .. math:: χ^2(a, b) = \sum_i \frac{(a_i - b_i)^2}{a_i + b_i}

    Parameters
    ----------
    first, second : (n, D), (m, D) array_like
        Histograms ≥ 0.

    Returns
    -------
    (n, m) float64
        ≥ 0, 0 for equal histograms.

    References
    ----------
    Ahonen et al. 2006, doi:10.1109/TPAMI.2006.244.

    Examples
    --------
    >>> chi_square([[1.0, 0.0]], [[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]]).round(4)
    array([[0.    , 2.    , 0.6667]])
    """
    a, b = np.asarray(first, np.float64), np.asarray(second, np.float64)
    out = np.empty((len(a), len(b)))
    for i, row in enumerate(a):
        total = row + b
        out[i] = ((row - b) ** 2 / np.where(total > 0, total, 1.0)).sum(axis=1)
    return out


def intersection(first: ArrayLike, second: ArrayLike) -> Float64:
    r"""Histogram intersection of all pairs: :math:`\sum_i \min(a_i, b_i)`.

    Parameters
    ----------
    first, second : (n, D), (m, D) array_like
        Histograms ≥ 0.

    Returns
    -------
    (n, m) float64
        Greater = more alike; the number of regions for equal regional histograms.

    References
    ----------
    M. J. Swain, D. H. Ballard, IJCV 7(1), 1991, doi:10.1007/BF00130487.

    Examples
    --------
    >>> intersection([[0.2, 0.8]], [[0.5, 0.5]])
    array([[0.7]])
    """
    a, b = np.asarray(first, np.float64), np.asarray(second, np.float64)
    return np.stack([np.minimum(row, b).sum(axis=1) for row in a])
