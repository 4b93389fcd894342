"""Unwrapping of a periodic image in space."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray


@njit(cache=True, nogil=True)
def _root(parent: NDArray[np.int32], turns: NDArray[np.int32], node: int) -> tuple[int, int]:
    """Root of a node and the node's turns relative to it, with path halving."""
    total = 0
    while parent[node] != node:
        up = parent[node]
        turns[node] += turns[up] if parent[up] != up else 0
        parent[node] = parent[up]
        total += turns[node]
        node = parent[node]
    return node, total


@njit(cache=True, nogil=True)
def _join(
    phase: NDArray[np.float64], edges: NDArray[np.int32], period: float
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    n = len(phase)
    parent = np.arange(n).astype(np.int32)
    turns = np.zeros(n, dtype=np.int32)
    size = np.ones(n, dtype=np.int32)
    for k in range(len(edges)):
        a, b = edges[k, 0], edges[k, 1]
        root_a, turns_a = _root(parent, turns, a)
        root_b, turns_b = _root(parent, turns, b)
        if root_a == root_b:
            continue
        # the turn that brings b within half a period of a
        step = int(np.rint((phase[a] - phase[b]) / period)) + turns_a - turns_b
        if size[root_a] < size[root_b]:
            root_a, root_b, step = root_b, root_a, -step
        parent[root_b] = root_a
        turns[root_b] = step
        size[root_a] += size[root_b]
    labels = np.empty(n, dtype=np.int32)
    total = np.empty(n, dtype=np.int32)
    for i in range(n):
        labels[i], total[i] = _root(parent, turns, i)
    return labels, total


def unwrap_2d(wrapped: ArrayLike, *, period: float) -> NDArray[np.float64]:
    r"""Unwrap an image that is known modulo a period, most reliable neighbours first.

    Neighbours are joined in the order of their reliability, the inverse of the second
    differences around them; each join adds the whole turns that bring the two within half a
    period. An island has no neighbour to hang on: it takes the turns that bring its median
    closest to the largest island's.

    Parameters
    ----------
    wrapped : (H, W) array_like
        Values in [0, period); NaN where unknown.
    period : float
        The period, > 0.

    Returns
    -------
    (H, W) float64
        Values that agree with `wrapped` modulo the period; NaN where it is.

    Notes
    -----
    Right where neighbours differ by less than half a period; a sharper edge is unwrapped
    around if the image allows it.

    References
    ----------
    M. A. Herráez et al., Applied Optics 41(35), 2002, doi:10.1364/AO.41.007437 (here without
    wrap-around of the image, and with islands).

    Examples
    --------
    >>> ramp = np.tile(np.arange(0.0, 3.0, 0.4), (3, 1))
    >>> np.allclose(unwrap_2d(ramp % 1.0, period=1.0), ramp)
    True
    """
    phase = np.asarray(wrapped, dtype=np.float64)
    known = np.isfinite(phase)
    if not known.any():
        return phase.copy()
    labels, turns = _join(phase.ravel(), _edges(phase, known, period), period)
    out = phase + period * turns.reshape(phase.shape)
    islands = np.where(known, labels.reshape(phase.shape), -1)
    names, sizes = np.unique(islands[known], return_counts=True)
    largest = np.median(out[islands == names[sizes.argmax()]])
    if len(names) > 1:
        out = _level_islands(out, islands, largest, period)
    # the whole image is free by a turn: let the largest island start in the first period
    base = np.floor(np.nanmin(out[islands == names[sizes.argmax()]]) / period)
    return out - base * period


def _level_islands(
    values: NDArray[np.float64], islands: NDArray[np.int32], level: float, period: float
) -> NDArray[np.float64]:
    """Each island shifted by the whole periods that bring its median closest to the level."""
    order = np.argsort(islands, axis=None, kind="stable")
    sorted_islands = islands.ravel()[order]
    starts = np.flatnonzero(np.r_[True, sorted_islands[1:] != sorted_islands[:-1]])
    out = values.copy().ravel()
    for part in np.split(order, starts[1:]):
        if islands.ravel()[part[0]] >= 0:
            out[part] += period * np.rint((level - np.median(out[part])) / period)
    return out.reshape(values.shape)


def _edges(
    phase: NDArray[np.float64], known: NDArray[np.bool_], period: float
) -> NDArray[np.int32]:
    """Pairs of known neighbours (m, 2), most reliable first."""

    def wrap(difference: NDArray[np.float64]) -> NDArray[np.float64]:
        return difference - period * np.rint(difference / period)

    padded = np.pad(phase, 1, constant_values=np.nan)
    roughness = np.zeros_like(phase)
    h, w = phase.shape
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        before = padded[1 - dy : 1 - dy + h, 1 - dx : 1 - dx + w]
        after = padded[1 + dy : 1 + dy + h, 1 + dx : 1 + dx + w]
        second = wrap(before - phase) - wrap(phase - after)
        roughness += np.where(np.isfinite(second), second**2, period**2)
    index = np.arange(phase.size, dtype=np.int32).reshape(phase.shape)
    pairs, cost = [], []
    for a, b in (
        ((slice(None), slice(None, -1)), (slice(None), slice(1, None))),
        ((slice(None, -1), slice(None)), (slice(1, None), slice(None))),
    ):
        both = known[a] & known[b]
        pairs.append(np.stack([index[a][both], index[b][both]], axis=1))
        cost.append((roughness[a] + roughness[b])[both])
    return np.concatenate(pairs)[np.argsort(np.concatenate(cost), kind="stable")]
