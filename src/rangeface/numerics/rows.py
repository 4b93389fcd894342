"""Rows of scalars and counted lists, as PLY stores its elements, walked once."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

#: Bytes of the scalar types: int8, uint8, int16, uint16, int32, uint32, float32, float64.
SIZES = np.array([1, 1, 2, 2, 4, 4, 4, 8])


@njit(cache=True, nogil=True)
def _integer(data: NDArray[np.uint8], at: int, code: int, big: bool) -> int:
    if code == 1:
        return int(data[at])
    size = 1 << (code // 2)
    value = 0
    for k in range(size):
        value |= int(data[at + (size - 1 - k if big else k)]) << (8 * k)
    if code % 2 == 0 and value >= 1 << (8 * size - 1):
        value -= 1 << (8 * size)
    return value


@njit(cache=True, nogil=True)
def walk_binary(
    data: NDArray[np.uint8],
    start: int,
    rows: int,
    layout: NDArray[np.int64],
    wanted: int,
    big: bool,
    sizes: NDArray[np.int64],
    counts: NDArray[np.int64],
    items: NDArray[np.int64],
) -> tuple[int, int, int]:
    """Walk rows of scalars and lists in binary data, and collect one list property.

    Parameters
    ----------
    data : (n,) uint8
        The bytes.
    start : int
        Offset of the first row.
    rows : int
        Number of rows.
    layout : (p, 2) int64
        A property a row: type code of a list's count (−1 for a scalar) and of the value.
    wanted : int
        Index of the list property to collect, −1 for none; of an integer type.
    big : bool
        Whether the bytes are big-endian.
    sizes : (8,) int64
        Bytes of each type, `SIZES`.
    counts : (rows or 0,) int64
        Filled with the lists' lengths, unless empty.
    items : (k,) int64
        Filled with the lists' values, as many as fit.

    Returns
    -------
    done : int
        Rows that are whole.
    stop : int
        Offset behind them.
    total : int
        Values in the wanted lists.
    """
    at, total = start, 0
    for row in range(rows):
        begin = at
        for p in range(len(layout)):
            count, code = 1, layout[p, 1]
            if layout[p, 0] >= 0:
                if at + sizes[layout[p, 0]] > len(data):
                    return row, begin, total
                count = _integer(data, at, layout[p, 0], big)
                at += sizes[layout[p, 0]]
            width = sizes[code]
            if count < 0 or count * width > len(data) - at:
                return row, begin, total
            if p == wanted:
                if len(counts):
                    counts[row] = count
                for k in range(min(count, len(items) - total)):
                    items[total + k] = _integer(data, at + k * width, code, big)
                total += count
            at += count * width
    return rows, at, total


@njit(cache=True, nogil=True)
def walk_numbers(
    values: NDArray[np.float64],
    start: int,
    rows: int,
    is_list: NDArray[np.bool_],
    wanted: int,
    counts: NDArray[np.int64],
    items: NDArray[np.int64],
) -> tuple[int, int, int]:
    """Walk rows of scalars and lists in numbers that were read from text.

    Parameters
    ----------
    values : (n,) float64
        The numbers.
    start : int
        Index of the first row's first number.
    rows : int
        Number of rows.
    is_list : (p,) bool
        Which properties are lists, a count and then so many values.
    wanted : int
        Index of the list property to collect, −1 for none.
    counts, items : int64 arrays
        As in `walk_binary`.

    Returns
    -------
    done, stop, total : int
        As in `walk_binary`, counted in numbers.
    """
    at, total = start, 0
    for row in range(rows):
        begin = at
        for p in range(len(is_list)):
            count = 1.0
            if is_list[p]:
                if at >= len(values):
                    return row, begin, total
                count = values[at]
                at += 1
            if not 0 <= count <= len(values) - at:
                return row, begin, total
            whole = int(count)
            if p == wanted:
                if len(counts):
                    counts[row] = whole
                if len(items):
                    for k in range(whole):
                        value = values[at + k]
                        items[total + k] = int(value) if abs(value) < 2**53 else -1
                total += whole
            at += whole
    return rows, at, total


@njit(cache=True, nogil=True)
def strip_triangles(strip: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut triangle strips, each closed by −1, into triangles (t, 3), every other one turned."""
    out = np.empty((len(strip), 3), dtype=np.int64)
    row = length = 0
    for i in range(len(strip)):
        length = 0 if strip[i] < 0 else length + 1
        if length >= 3:
            turned = length % 2 == 0
            out[row, 0] = strip[i - 1] if turned else strip[i - 2]
            out[row, 1] = strip[i - 2] if turned else strip[i - 1]
            out[row, 2] = strip[i]
            row += 1
    return out[:row]
