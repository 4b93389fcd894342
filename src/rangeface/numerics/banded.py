"""Linear filters along the rows of an image, as sparse matrices.

A level of a wavelet transform, with its decimation and its border, is a matrix with a handful
of entries a row. Applied down the columns, its inner loop runs along contiguous memory; the
other axis is the same matrix between two transpositions.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

Image: TypeAlias = NDArray[np.float32]

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}
_TILE = 16


class Banded(NamedTuple):
    """Compressed rows: entry k of row r is weight[k] at column[k], start[r] ≤ k < start[r + 1]."""

    start: NDArray[np.int32]
    column: NDArray[np.int32]
    weight: Image


def banded(
    rows: ArrayLike, columns: ArrayLike, weights: ArrayLike, shape: tuple[int, int]
) -> Banded:
    """Matrix from its entries; entries at the same place add up.

    Parameters
    ----------
    rows, columns, weights : (n,) array_like
        Entries.
    shape : tuple of int
        Rows and columns.

    Returns
    -------
    Banded

    Examples
    --------
    >>> apply(banded([0, 0], [0, 2], [1.0, 2.0], (1, 3)), np.float32([[1], [5], [3]]))
    array([[7.]], dtype=float32)
    """
    entries = (np.ravel(weights), (np.ravel(rows), np.ravel(columns)))
    return _banded(sparse.csr_array(sparse.coo_array(entries, shape=shape)))


def adjoint(matrix: Banded, columns: int) -> Banded:
    """Transposed matrix; `columns` is the column count of the given one."""
    shape = (len(matrix.start) - 1, columns)
    csr = sparse.csr_array((matrix.weight, matrix.column, matrix.start), shape=shape)
    return _banded(sparse.csr_array(csr.T))


def _banded(csr: sparse.csr_array) -> Banded:
    csr.sum_duplicates()
    return Banded(
        csr.indptr.astype(np.int32), csr.indices.astype(np.int32), csr.data.astype(np.float32)
    )


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def accumulate(matrix: Banded, image: Image, out: Image) -> None:
    """Add ``matrix @ image`` to `out`, four taps at a time."""
    start, column, weight = matrix
    cols = image.shape[1]
    for r in range(out.shape[0]):
        line = out[r]
        k, end = start[r], start[r + 1]
        while k + 4 <= end:
            w0, w1, w2, w3 = weight[k], weight[k + 1], weight[k + 2], weight[k + 3]
            x0, x1 = image[column[k]], image[column[k + 1]]
            x2, x3 = image[column[k + 2]], image[column[k + 3]]
            for c in range(cols):
                line[c] += (w0 * x0[c] + w1 * x1[c]) + (w2 * x2[c] + w3 * x3[c])
            k += 4
        while k < end:
            w0, x0 = weight[k], image[column[k]]
            for c in range(cols):
                line[c] += w0 * x0[c]
            k += 1


@njit(cache=True, nogil=True)
def apply(matrix: Banded, image: Image) -> Image:
    """``matrix @ image``, float32."""
    out = np.zeros((matrix.start.shape[0] - 1, image.shape[1]), dtype=np.float32)
    accumulate(matrix, image, out)
    return out


@njit(cache=True, nogil=True)
def transpose(image: Image) -> Image:
    """Transposed copy, tile by tile, so that both sides stay in the cache."""
    rows, cols = image.shape
    out = np.empty((cols, rows), dtype=np.float32)
    for r0 in range(0, rows, _TILE):
        for c0 in range(0, cols, _TILE):
            for c in range(c0, min(c0 + _TILE, cols)):
                for r in range(r0, min(r0 + _TILE, rows)):
                    out[c, r] = image[r, c]
    return out


@njit(cache=True, nogil=True)
def split(
    image: Image, low_v: Banded, high_v: Banded, low_h: Banded, high_h: Banded
) -> tuple[Image, Image, Image, Image]:
    """One analysis level: the four sub-bands of an image, *transposed*.

    Parameters
    ----------
    image : (H, W) float32
        Finite.
    low_v, high_v : Banded
        Filters down the columns, (H', H).
    low_h, high_h : Banded
        Filters along the rows, (W', W).

    Returns
    -------
    ll, lh, hl, hh : (W', H') float32
        First letter: vertical, second: horizontal; l = low, h = high. The next level takes the
        transposed ll as it is, with the two axes' filters exchanged: no transposition is undone.
    """
    low, high = transpose(apply(low_v, image)), transpose(apply(high_v, image))
    return apply(low_h, low), apply(high_h, low), apply(low_h, high), apply(high_h, high)


@njit(cache=True, nogil=True)
def merge(
    ll: Image,
    lh: Image,
    hl: Image,
    hh: Image,
    low_v: Banded,
    high_v: Banded,
    low_h: Banded,
    high_h: Banded,
) -> Image:
    """One synthesis level, from the sub-bands of `split` and the synthesis filters."""
    low, high = apply(low_h, ll), apply(low_h, hl)
    accumulate(high_h, lh, low)
    accumulate(high_h, hh, high)
    out = apply(low_v, transpose(low))
    accumulate(high_v, transpose(high), out)
    return out


def noise_gains(levels: list[tuple[Banded, Banded]], length: int) -> list[tuple[float, float]]:
    """Standard deviation of white unit noise in the sub-bands of a separable transform.

    Parameters
    ----------
    levels : list of (low, high)
        Analysis matrices of successive levels, the first for `length` samples.
    length : int
        At least 1.5 times what a filter of the last level spans.

    Returns
    -------
    list of (side, diagonal)
        Per level: of lh and hl, and of hh. Root mean squares over the middle quarter of the
        rows, where no border is seen.

    Examples
    --------
    >>> haar = [banded([0, 0, 1, 1], [0, 1, 2, 3], np.sqrt(0.5) * np.array(signs), (2, 4))
    ...         for signs in ([1, 1, 1, 1], [1, -1, 1, -1])]
    >>> [round(gain, 6) for gain in noise_gains([(haar[0], haar[1])], 4)[0]]
    [1.0, 1.0]
    """
    cascade = np.eye(length, dtype=np.float32)
    gains = []
    for low, high in levels:
        detail = _rms_row(apply(high, cascade))
        cascade = apply(low, cascade)
        gains.append((_rms_row(cascade) * detail, detail * detail))
    return gains


def _rms_row(rows: Image) -> float:
    edge = 3 * len(rows) // 8
    middle = rows[edge : len(rows) - edge]
    return float(np.sqrt(np.mean(np.sum(middle.astype(np.float64) ** 2, axis=1))))
