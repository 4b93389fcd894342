"""Polygons of any size cut into triangles."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def fan(indices: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut polygons into fans of triangles.

    Parameters
    ----------
    indices : (k,) int64
        Corners of all polygons, one after the other.
    sizes : (m,) int64
        Corners of each polygon, ≥ 0, with sum k; fewer than three corners make no triangle.

    Returns
    -------
    (t, 3) int64
        Triangles in the order and orientation of the polygons.

    Examples
    --------
    >>> fan(np.array([0, 1, 2, 3]), np.array([4]))
    array([[0, 1, 2],
           [0, 2, 3]])
    """
    total = 0
    for size in sizes:
        total += max(size - 2, 0)
    out = np.empty((total, 3), dtype=np.int64)
    row = start = 0
    for size in sizes:
        for k in range(1, size - 1):
            out[row, 0] = indices[start]
            out[row, 1] = indices[start + k]
            out[row, 2] = indices[start + k + 1]
            row += 1
        start += size
    return out


@njit(cache=True, nogil=True)
def grid_triangles(points: NDArray[np.float32], max_edge: float) -> NDArray[np.int64]:
    """Join the points of a grid into triangles, but not across a jump.

    Parameters
    ----------
    points : (H, W, 3) float32
        Organised points, NaN where invalid.
    max_edge : float
        Longest edge of a triangle, in the unit of the points, > 0.

    Returns
    -------
    (t, 3) int64
        Row-major indices of the corners.

    Examples
    --------
    >>> xy = np.zeros((2, 2, 3), dtype=np.float32)
    >>> xy[..., 0], xy[..., 1] = [[0, 1], [0, 1]], [[0, 0], [1, 1]]
    >>> grid_triangles(xy, 2.0)
    array([[0, 1, 2],
           [1, 3, 2]])
    """
    height, width = points.shape[:2]
    out = np.empty((2 * max(height - 1, 0) * max(width - 1, 0), 3), dtype=np.int64)
    flat = points.reshape(-1, 3)
    row = 0
    for r in range(height - 1):
        for c in range(width - 1):
            a = r * width + c
            for k in range(2):
                p = a if k == 0 else a + 1
                q = a + 1 if k == 0 else a + width + 1
                s = a + width
                longest = 0.0
                for i, j in ((p, q), (q, s), (s, p)):
                    d = (
                        (flat[i, 0] - flat[j, 0]) ** 2
                        + (flat[i, 1] - flat[j, 1]) ** 2
                        + (flat[i, 2] - flat[j, 2]) ** 2
                    )
                    longest = max(longest, d) if np.isfinite(d) else np.inf
                if longest <= max_edge * max_edge:
                    out[row, 0], out[row, 1], out[row, 2] = p, q, s
                    row += 1
    return out[:row]


@njit(cache=True, nogil=True)
def fan_closed(indices: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut polygons that are each closed by a negative index into fans of triangles.

    Parameters
    ----------
    indices : (k,) int64
        Corners; the last polygon needs no closing index.

    Returns
    -------
    (t, 3) int64
        Triangles.

    Examples
    --------
    >>> fan_closed(np.array([0, 1, 2, -1, 2, 1, 3]))
    array([[0, 1, 2],
           [2, 1, 3]])
    """
    out = np.empty((len(indices), 3), dtype=np.int64)
    row, first = 0, 0
    for i in range(len(indices)):
        if indices[i] < 0:
            first = i + 1
        elif i >= first + 2:
            out[row, 0] = indices[first]
            out[row, 1] = indices[i - 1]
            out[row, 2] = indices[i]
            row += 1
    return out[:row].copy()
