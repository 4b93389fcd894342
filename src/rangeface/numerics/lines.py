"""Tables whose rows are lines of text."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.numerics.text import number_at

_SEMICOLON, _COMMA, _HASH = 59, 44, 35


@njit(cache=True, nogil=True)
def _gap(c: int) -> bool:
    return c in (32, 9, _COMMA, _SEMICOLON)


@njit(cache=True, nogil=True)
def _line(text: NDArray[np.uint8], at: int, out: NDArray[np.float64]) -> tuple[int, int, bool]:
    """Numbers of one line into `out`: how many, the next line's offset, whether all are numbers.

    Numbers beyond the length of `out` are counted but not kept.
    """
    n, count, good = len(text), 0, True
    while at < n and text[at] != 10 and text[at] != 13:
        if _gap(text[at]):
            at += 1
            continue
        if text[at] == _HASH:
            while at < n and text[at] != 10 and text[at] != 13:
                at += 1
            break
        stop = at
        while stop < n and not _gap(text[stop]) and text[stop] != 10 and text[stop] != 13:
            stop += 1
        value, number = number_at(text, at, stop)
        if good and number:
            if count < len(out):
                out[count] = value
            count += 1
        else:
            good = False
        at = stop
    while at < n and (text[at] == 10 or text[at] == 13):
        at += 1
    return count, at, good


@njit(cache=True, nogil=True)
def first_line(text: NDArray[np.uint8], at: int, most: int) -> tuple[NDArray[np.float64], int]:
    """Read the first line that holds a number.

    Parameters
    ----------
    text : (n,) uint8
        The bytes; ``#`` begins a comment, blanks, tabs, commas and semicolons separate.
    at : int
        Where to begin.
    most : int
        Keep at most so many numbers.

    Returns
    -------
    values : (k,) float64
        Empty where no line holds a number.
    next : int
        Offset of the next line.
    """
    out = np.empty(most)
    while at < len(text):
        count, at, good = _line(text, at, out)
        if count and good:
            return out[: min(count, most)], at
        if not good:
            break
    return out[:0], at


@njit(cache=True, nogil=True)
def read_table(
    text: NDArray[np.uint8], at: int, rows: int, columns: int
) -> tuple[NDArray[np.float64], int]:
    """Read the first columns of a table, one row a line.

    Parameters
    ----------
    text : (n,) uint8
        The bytes, as in `first_line`.
    at : int
        Where to begin.
    rows : int
        Rows to read; blank and comment lines do not count.
    columns : int
        Columns to keep; further ones are passed over.

    Returns
    -------
    table : (k, columns) float64
        k < rows where a line is shorter than `columns`, holds no number, or the text ends.
    next : int
        Offset of the first line that was not read.
    """
    table = np.empty((rows, columns))
    row = 0
    while row < rows and at < len(text):
        count, following, good = _line(text, at, table[row])
        if count >= columns:
            row += 1
        elif count or not good:
            break
        at = following
    return table[:row], at


@njit(cache=True, nogil=True)
def count_rows(text: NDArray[np.uint8], at: int) -> int:
    """Count the lines that hold at least one number."""
    none, rows = np.empty(0), 0
    while at < len(text):
        count, at, _ = _line(text, at, none)
        rows += 1 if count else 0
    return rows


@njit(cache=True, nogil=True)
def read_polygons(
    text: NDArray[np.uint8], at: int, rows: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Read polygons, one a line: the number of corners, the corners, anything else.

    Parameters
    ----------
    text : (n,) uint8
        The bytes, as in `first_line`.
    at : int
        Where to begin.
    rows : int
        Polygons to read.

    Returns
    -------
    sizes : (k,) int64
        k < rows where a line does not hold the corners it announces.
    indices : (sum of sizes,) int64
    next : int
        Offset of the first line that was not read.
    """
    sizes = np.empty(rows, dtype=np.int64)
    indices = np.empty(max((len(text) - at) // 2, 0) + 1, dtype=np.int64)
    row = total = 0
    values = np.empty(64)
    while row < rows and at < len(text):
        count, following, _ = _line(text, at, values)
        if count == 0:
            if following == at:
                break
            at = following
            continue
        size = values[0]
        if not (0 <= size < count) or size >= 64:
            break
        for k in range(int(size)):
            value = values[k + 1]
            indices[total + k] = int(value) if abs(value) < 2**53 else -1
        sizes[row] = int(size)
        total += int(size)
        row += 1
        at = following
    return sizes[:row], indices[:total], at
