"""How alike the rows of two arrays are: the search kernels, without a copy of the gallery.

Each pair is summed on its own, difference by difference, so a probe's score depends neither on
the probes beside it nor on the number of threads, and near-identical rows lose no digits (the
matrix-product form |p|² + |g|² − 2 p·g would).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError

Scores: TypeAlias = NDArray[np.float32]

#: A cosine nearer to 1 than this says no more: its inverse hyperbolic tangent has no bound.
_MOST_ALIKE = np.float32(0.9999)
_FAST = {"contract", "reassoc", "arcp", "nsz"}


@njit(cache=True, nogil=True, fastmath=_FAST)
def _negative_distance(P, G, out):  # type: ignore[no-untyped-def]
    for j in range(G.shape[0]):
        g = G[j]
        for i in range(P.shape[0]):
            p = P[i]
            total = np.float32(0.0)
            for d in range(p.shape[0]):
                difference = p[d] - g[d]
                total += difference * difference
            out[i, j] = -np.sqrt(total)


@njit(cache=True, nogil=True, fastmath=_FAST)
def _cosine(P, G, out):  # type: ignore[no-untyped-def]
    for j in range(G.shape[0]):
        g = G[j]
        for i in range(P.shape[0]):
            p = P[i]
            pg = np.float32(0.0)
            pp = np.float32(0.0)
            gg = np.float32(0.0)
            for d in range(p.shape[0]):
                pg += p[d] * g[d]
                pp += p[d] * p[d]
                gg += g[d] * g[d]
            norm = np.sqrt(pp) * np.sqrt(gg)
            out[i, j] = pg / norm if norm > 0.0 else np.float32(0.0)


@njit(cache=True, nogil=True, fastmath=_FAST)
def _negative_chi_square(P, G, out):  # type: ignore[no-untyped-def]
    for j in range(G.shape[0]):
        g = G[j]
        for i in range(P.shape[0]):
            p = P[i]
            total = np.float32(0.0)
            for d in range(p.shape[0]):
                both = p[d] + g[d]
                difference = p[d] - g[d]
                total += difference * difference / both if both > 0.0 else np.float32(0.0)
            out[i, j] = -np.float32(0.5) * total


@njit(cache=True, nogil=True, fastmath=_FAST)
def _intersection(P, G, out):  # type: ignore[no-untyped-def]
    for j in range(G.shape[0]):
        g = G[j]
        for i in range(P.shape[0]):
            p = P[i]
            total = np.float32(0.0)
            for d in range(p.shape[0]):
                total += min(p[d], g[d])
            out[i, j] = total


def _fisher_z(P: Scores, G: Scores, out: Scores) -> None:
    _cosine(P, G, out)
    np.arctanh(np.clip(out, -_MOST_ALIKE, _MOST_ALIKE, out=out), out=out)


KERNELS = {
    "euclidean": _negative_distance,
    "cosine": _cosine,
    "fisher-z": _fisher_z,
    "chi-square": _negative_chi_square,
    "intersection": _intersection,
}


def similarity(probes: ArrayLike, gallery: ArrayLike, *, metric: str = "euclidean") -> Scores:
    r"""Similarity of every probe to every gallery row; higher = more alike.

    .. math::
        s_{euclidean} = -\|p - g\|, \quad s_{cosine} = \frac{p·g}{\|p\|\,\|g\|}, \quad
        s_{z} = \operatorname{artanh} s_{cosine}, \quad
        s_{χ²} = -\tfrac12 \sum_d \frac{(p_d - g_d)^2}{p_d + g_d}, \quad
        s_{intersection} = \sum_d \min(p_d, g_d)

    Parameters
    ----------
    probes : (n, D) array_like
        Probe vectors; used as float32.
    gallery : (m, D) array_like
        Gallery vectors; not copied where they are C-ordered float32.
    metric : {"euclidean", "cosine", "fisher-z", "chi-square", "intersection"}
        Kind of similarity. "fisher-z" orders as the cosine does, but its scale does not shrink near
        1: scores of different probes compare, and a norm by their spread leaves mates apart from
        strangers. The last two are for histograms (values ≥ 0).

    Returns
    -------
    (n, m) float32
        Scores. The cosine with a zero vector is 0; "fisher-z" lies within ±4.95.

    Raises
    ------
    ParameterError
        The metric is unknown, or the rows differ in length.

    Notes
    -----
    One pass over the gallery, O(n m D); for one probe it runs at the speed of memory.

    References
    ----------
    R. A. Fisher, Biometrika 10(4), 1915, doi:10.2307/2331838 (the transformation of a correlation).

    Examples
    --------
    >>> similarity([[0.0, 0.0]], [[3.0, 4.0], [0.0, 0.0]]) + 0.0
    array([[-5.,  0.]], dtype=float32)
    """
    P = np.ascontiguousarray(probes, dtype=np.float32)
    G = np.ascontiguousarray(gallery, dtype=np.float32)
    if metric not in KERNELS:
        raise ParameterError(f"metric: unknown {metric!r}; known are {', '.join(KERNELS)}")
    if P.ndim != 2 or G.ndim != 2 or P.shape[1] != G.shape[1]:
        raise ParameterError(
            f"probes, gallery: need rows of one length, got {P.shape} and {G.shape}"
        )
    scores = np.empty((len(P), len(G)), dtype=np.float32)
    KERNELS[metric](P, G, scores)
    return scores
