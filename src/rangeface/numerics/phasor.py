"""Phasors of phase-shift range measurement: buckets to phase, phase to range, and their noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def decode(buckets: ArrayLike) -> NDArray[np.complex64]:
    r"""Phasor of N equally spaced buckets.

    .. math:: A e^{iφ} = \frac{2}{N} \sum_{k=0}^{N-1} I_k e^{-2πik/N}
              \quad\text{for}\quad I_k = B + A \cos(φ + 2πk/N)

    Parameters
    ----------
    buckets : (..., N, H, W) array_like
        Counts, N ≥ 3.

    Returns
    -------
    (..., H, W) complex64
        Unbiased whatever the zero-mean noise of the buckets.

    Examples
    --------
    >>> phase = 1.2 + np.pi / 2 * np.arange(4)
    >>> signal = decode((50.0 + 10.0 * np.cos(phase)).reshape(4, 1, 1))
    >>> round(float(np.abs(signal[0, 0])), 4), round(float(np.angle(signal[0, 0])), 4)
    (10.0, 1.2)
    """
    counts = np.asarray(buckets, np.float32)
    steps = counts.shape[-3]
    weights = 2.0 / steps * np.exp(-2j * np.pi * np.arange(steps) / steps)
    return np.asarray(np.einsum("k,...khw->...hw", weights.astype(np.complex64), counts))


def unwrap(phases: ArrayLike, ambiguities_mm: ArrayLike, longest_mm: float) -> NDArray[np.float64]:
    r"""Range that agrees best with the phases of several frequencies.

    Of the ranges (φ_1/2π + n) L_1 below the common period the one with the least weighted sum of
    squared disagreements is taken, then all frequencies are averaged with weights 1/L².

    Parameters
    ----------
    phases : (f, H, W) array_like
        Phases, rad.
    ambiguities_mm : (f,) array_like
        Unambiguous range of each, mm.
    longest_mm : float
        Their common period, mm.

    Returns
    -------
    (H, W) float64
        Range, mm, in [0, longest).

    Examples
    --------
    >>> L = np.array([1000.0, 700.0])
    >>> phases = (2 * np.pi * 4321.0 / L).reshape(2, 1, 1)
    >>> float(unwrap(phases, L, 7000.0)[0, 0].round(6))
    4321.0
    """
    L = np.asarray(ambiguities_mm, np.float64)
    ranges = np.mod(np.asarray(phases, np.float64) / (2.0 * np.pi), 1.0) * L[:, None, None]
    if len(L) == 1:
        return ranges[0]
    weight = (1.0 / L**2) / np.sum(1.0 / L**2)
    best = np.full(ranges.shape[1:], np.inf)
    found = np.zeros(ranges.shape[1:])
    for n in range(max(1, round(longest_mm / L[0]))):
        candidate = ranges[0] + n * L[0]
        away = ranges - candidate
        away -= L[:, None, None] * np.round(away / L[:, None, None])
        cost = np.einsum("f,fhw->hw", weight, away**2)
        nearer = cost < best
        best = np.where(nearer, cost, best)
        found = np.where(nearer, candidate + np.einsum("f,fhw->hw", weight, away), found)
    return found
