"""The levels of the dual-tree transform in one dimension, as banded matrices.

The two trees travel interleaved: sample 2n belongs to one, 2n + 1 to the other. Mirroring the
interleaved signal at its ends lets each tree continue with the other's samples, which is what
keeps q-shift filters, each the time reverse of the other, symmetric at the border.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rangeface.numerics.banded import Banded, adjoint, banded
from rangeface.numerics.dtcwt.filters import FARRAS, Taps, first_level, q_shift

SELESNICK = "selesnick"


class Level(NamedTuple):
    """Matrices of one level for one length: analysis (low, high), synthesis (low, high)."""

    low: Banded
    high: Banded
    low_back: Banded
    high_back: Banded


@lru_cache(maxsize=256)
def level(number: int, length: int, first: str, further: str) -> Level:
    """Matrices of level `number` (1 = finest) for an input of `length` samples.

    Parameters
    ----------
    number : int
        ≥ 1.
    length : int
        Even at level 1, else a multiple of 4.
    first, further : str
        Names of the filters; "selesnick" as `first` stands for Selesnick's pair of banks.

    Returns
    -------
    Level
    """
    if first == SELESNICK:
        bank = FARRAS if number == 1 else q_shift("qshift_06")
        return _periodic(bank.h0, bank.h1, length, interleaved=number > 1)
    if number == 1:
        shared = first_level(first)
        taps = (shared.h0, shared.h1, shared.g0, shared.g1)
        return Level(*(_mirrored(h, length) for h in taps))
    f = q_shift(further)
    low = _decimated(f.h0[::-1], f.h0, length, even_first=True)
    high = _decimated(f.h1[::-1], f.h1, length, even_first=False)
    # each tree is orthonormal, so synthesis is the adjoint
    return Level(low, high, adjoint(low, length), adjoint(high, length))


def _reflected(index: NDArray[np.int64], length: int) -> NDArray[np.int64]:
    """Half-sample symmetric extension: … 1 0 | 0 1 … n−1 | n−1 n−2 …"""
    folded = np.mod(index, 2 * length)
    return np.where(folded < length, folded, 2 * length - 1 - folded)


def _mirrored(taps: Taps, length: int) -> Banded:
    """Undecimated symmetric odd filter: row n holds h[k] at n + c − k."""
    n, k = np.mgrid[:length, : len(taps)]
    columns = _reflected(n + len(taps) // 2 - k, length)
    return banded(n, columns, np.broadcast_to(taps, n.shape), (length, length))


def _decimated(even: Taps, odd: Taps, length: int, *, even_first: bool) -> Banded:
    """Both trees' filters, each decimated by two: (length / 2, length).

    The tree on even samples reads h[k] at 4n + m − 2k, that on odd ones at 4n + m + 1 − 2k.
    """
    m = len(even)
    n, k = np.mgrid[: length // 4, :m]
    rows = np.stack([2 * n, 2 * n + 1] if even_first else [2 * n + 1, 2 * n])
    columns = _reflected(np.stack([4 * n + m - 2 * k, 4 * n + m + 1 - 2 * k]), length)
    weights = np.broadcast_to(np.stack([even, odd])[:, None, :], rows.shape)
    return banded(rows, columns, weights, (length // 2, length))


def _periodic(h0: Taps, h1: Taps, length: int, *, interleaved: bool) -> Level:
    """Selesnick's levels: periodic, the second tree with the time-reversed filters.

    At level 1 both trees read the same samples, the second one later; each gets half the energy.
    """
    stride = 2 if interleaved else 1
    samples = length // stride
    scale = 1.0 if interleaved else np.sqrt(0.5)

    def matrix(taps: Taps, sign: float) -> Banded:
        m = len(taps)
        n, k = np.mgrid[: samples // 2, :m]
        read = np.mod(2 * n + m // 2 - k, samples) * stride
        rows = np.stack([2 * n, 2 * n + 1])
        # the second tree: its own samples lie one further, and so does its view of shared ones
        columns = np.stack([read, np.mod(read + 1, length)])
        both = scale * np.stack([taps, sign * taps[::-1]])
        weights = np.broadcast_to(both[:, None, :], rows.shape)
        return banded(rows, columns, weights, (2 * (samples // 2), length))

    # the sign orders the six orientations as with the other banks
    low, high = matrix(h0, 1.0), matrix(h1, -1.0)
    return Level(low, high, adjoint(low, length), adjoint(high, length))
