"""Histograms of labels by region."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError, ParameterError

Float32: TypeAlias = NDArray[np.float32]


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
