"""The horizontal gradient operators of the paper."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.numerics.batches import as_batch

Float32: TypeAlias = NDArray[np.float32]


def hso(images: ArrayLike) -> Float32:
    r"""Horizontal Sobel operator.

    .. math:: \begin{pmatrix} -1 & 0 & 1 \\ -2 & 0 & 2 \\ -1 & 0 & 1 \end{pmatrix}

    Parameters
    ----------
    images : (…, H, W) array_like
        At least 3 × 3; NaN where invalid.

    Returns
    -------
    (…, H, W) float32
        In the unit of the images, finite: a pair of pixels that is not complete (at a hole or
        an edge) counts as level, and a hole itself has 0.

    Raises
    ------
    ParameterError
        The image is smaller than the operator.

    Notes
    -----
    Eq. 3.8 of the paper; correlation, not convolution: positive where values rise to the right.

    Examples
    --------
    >>> hso([[0, 1, 2], [0, 1, 4], [0, 1, 2]])[1, 1]
    np.float32(12.0)
    """
    batch, leading = as_batch(images, at_least=3)
    across = _pair(batch, 1)
    framed = np.pad(across, ((0, 0), (1, 1), (0, 0)))
    rows = framed[:, :-2] + 2.0 * framed[:, 1:-1] + framed[:, 2:]
    return _level_holes(rows, batch).reshape(*leading, *batch.shape[1:])


def lhg(images: ArrayLike) -> Float32:
    """Large horizontal gradient (−1 0 0 0 1).

    Parameters
    ----------
    images : (…, H, W) array_like
        At least 5 px wide and high; NaN where invalid.

    Returns
    -------
    (…, H, W) float32
        As for `hso`.

    Raises
    ------
    ParameterError
        The image is smaller than 5 × 5.

    Examples
    --------
    >>> lhg(np.tile([0.0, 5.0, 7.0, 1.0, 9.0], (5, 1)))[2]
    array([0., 0., 9., 0., 0.], dtype=float32)
    """
    batch, leading = as_batch(images, at_least=5)
    return _level_holes(_pair(batch, 2), batch).reshape(*leading, *batch.shape[1:])


def _pair(batch: Float32, distance: int) -> Float32:
    """Right minus left neighbour at a distance, 0 where one of them is missing."""
    difference = np.zeros_like(batch)
    difference[..., distance:-distance] = batch[..., 2 * distance :] - batch[..., : -2 * distance]
    return np.nan_to_num(difference, copy=False, nan=0.0)


def _level_holes(values: Float32, batch: Float32) -> Float32:
    return np.where(np.isnan(batch), np.float32(0.0), values)
