"""The two-dimensional transform as it is computed: real sub-bands of interleaved trees."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import banded
from rangeface.numerics.dtcwt.filters import first_level, q_shift
from rangeface.numerics.dtcwt.levels import SELESNICK, Level, level

Image: TypeAlias = NDArray[np.float32]
Bands: TypeAlias = tuple[Image, Image, Image]


@dataclass(eq=False)
class Subbands:
    """Real sub-bands of the interleaved trees.

    Parameters
    ----------
    shape : tuple of int
        Of the image.
    first, further : str
        Filters.
    lowpass : (H', W') float32
        What the coarsest level leaves.
    details : list of (lh, hl, hh)
        Per level, finest first. Levels 1, 3, … lie transposed: `banded.split` leaves them so.
    """

    shape: tuple[int, int]
    first: str
    further: str
    lowpass: Image
    details: list[Bands]


def check(levels: int, first: str, further: str) -> None:
    """Refuse a level count or a filter that does not exist.

    Raises
    ------
    ParameterError
        `levels` < 1, or an unknown filter.
    """
    if levels < 1:
        raise ParameterError(f"levels must be ≥ 1, got {levels}")
    if first != SELESNICK:
        first_level(first)
        q_shift(further)


def analyse(image: Image, levels: int, first: str, further: str) -> Subbands:
    """Sub-bands of a finite image (H, W) of any size ≥ 1 × 1."""
    x = np.ascontiguousarray(image, dtype=np.float32)
    details: list[Bands] = []
    for number in range(1, levels + 1):
        x = extended(x, number, axes=(0, 1))
        down, along = (level(number, n, first, further) for n in x.shape)
        x, lh, hl, hh = banded.split(x, down.low, down.high, along.low, along.high)
        details.append((lh, hl, hh))
    return Subbands((image.shape[0], image.shape[1]), first, further, x, details)


def synthesise(bands: Subbands) -> Image:
    """The image of its sub-bands."""
    # sizes going in, for each level, in the orientation that the level saw
    sizes = _sizes(bands.shape, len(bands.details))
    x = bands.lowpass
    for number in range(len(bands.details), 0, -1):
        rows, cols = sizes[number - 1]
        full = padded(rows, number), padded(cols, number)
        down, along = (level(number, n, bands.first, bands.further) for n in full)
        x = _merged(x, bands.details[number - 1], down, along)
        top, left = margin(rows, number), margin(cols, number)
        x = x[top : top + rows, left : left + cols]
    return np.ascontiguousarray(x)


def _merged(lowpass: Image, detail: Bands, down: Level, along: Level) -> Image:
    # the deeper level may have returned a window of a larger array
    return banded.merge(
        np.ascontiguousarray(lowpass),
        *detail,
        down.low_back,
        down.high_back,
        along.low_back,
        along.high_back,
    )


@lru_cache(maxsize=32)
def noise_gains(levels: int, first: str, further: str) -> list[tuple[float, float]]:
    """Standard deviation of white unit noise in each real part, per level: sides, diagonal."""
    length = 32 << levels
    matrices, n = [], length
    for number in range(1, levels + 1):
        step = level(number, n, first, further)
        matrices.append((step.low, step.high))
        n = n if number == 1 else n // 2
    return banded.noise_gains(matrices, length)


def padded(length: int, number: int) -> int:
    """Length after extension: even at level 1, a multiple of 4 further on."""
    if number == 1:
        return length + length % 2
    return length + 2 * (length % 4 != 0)


def margin(length: int, number: int) -> int:
    """Samples added before the first: one, where a multiple of 4 was needed."""
    return 0 if number == 1 else (padded(length, number) - length) // 2


def extended(x: Image, number: int, axes: tuple[int, ...]) -> Image:
    """The array with its edges repeated along `axes`, to the lengths that a level needs."""
    margins = [(0, 0)] * x.ndim
    for axis in axes:
        before = margin(x.shape[axis], number)
        margins[axis] = (before, padded(x.shape[axis], number) - x.shape[axis] - before)
    if not any(map(any, margins)):
        return x
    return np.pad(x, margins, mode="edge")


def lengths(length: int, levels: int) -> list[int]:
    """Length that enters each level, before its extension."""
    out = [length]
    for number in range(1, levels):
        out.append(padded(out[-1], number) // (1 if number == 1 else 2))
    return out


@lru_cache(maxsize=64)
def _sizes(shape: tuple[int, int], levels: int) -> list[tuple[int, int]]:
    """Size that enters each level, transposed with it."""
    pairs = zip(*(lengths(n, levels) for n in shape), strict=True)
    return [(b, a) if number % 2 else (a, b) for number, (a, b) in enumerate(pairs)]
