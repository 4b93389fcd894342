"""Points brought into another frame, and the invalid ones among them dropped."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def to_frame(
    points: NDArray[np.floating], rotation: NDArray[np.float64], farthest: float
) -> NDArray[np.float32]:
    """Multiply points by a matrix, and mark those that are not finite or too far.

    Parameters
    ----------
    points : (n, 3) float32 or float64
        The points; a non-finite coordinate makes a point invalid.
    rotation : (3, 3) float64
        The matrix, scale included.
    farthest : float
        Largest coordinate of a valid result, > 0.

    Returns
    -------
    (n, 3) float32
        The products; NaN in all three coordinates of an invalid point.

    Examples
    --------
    >>> to_frame(np.array([[1.0, 2.0, 3.0], [1e30, 0.0, 0.0]]), 10 * np.eye(3), 1e6)
    array([[10., 20., 30.],
           [nan, nan, nan]], dtype=float32)
    """
    out = np.empty(points.shape, dtype=np.float32)
    for i in range(len(points)):
        x, y, z = float(points[i, 0]), float(points[i, 1]), float(points[i, 2])
        good = True
        for k in range(3):
            value = 0.0
            # a zero of the matrix must not turn an infinity into NaN of its own
            if rotation[k, 0] != 0.0:
                value += rotation[k, 0] * x
            if rotation[k, 1] != 0.0:
                value += rotation[k, 1] * y
            if rotation[k, 2] != 0.0:
                value += rotation[k, 2] * z
            good = good and abs(value) <= farthest
            out[i, k] = value
        if not good:
            out[i, 0] = out[i, 1] = out[i, 2] = np.nan
    return out


@njit(cache=True, nogil=True)
def compact(
    points: NDArray[np.float32], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.int32], int]:
    """Drop the points that are NaN, and the triangles that touch one.

    Parameters
    ----------
    points : (n, 3) float32
        Invalid points are NaN in all coordinates.
    triangles : (m, 3) int64
        Indices into `points`.

    Returns
    -------
    points : (k, 3) float32
        The valid points in their order.
    triangles : (t, 3) int32
        The triangles between them, renumbered.
    wrong : int
        The first index that names no point, −1 where all do.

    Examples
    --------
    >>> nan = np.nan
    >>> p = np.array([[0, 0, 0], [nan, nan, nan], [1, 0, 0], [0, 1, 0]], dtype=np.float32)
    >>> compact(p, np.array([[0, 2, 3], [0, 1, 2]]))[1]
    array([[0, 1, 2]], dtype=int32)
    """
    n = len(points)
    number = np.empty(n, dtype=np.int32)
    kept = 0
    for i in range(n):
        number[i] = -1
        if points[i, 0] == points[i, 0]:
            number[i] = kept
            kept += 1
    out = np.empty((kept, 3), dtype=np.float32)
    for i in range(n):
        if number[i] >= 0:
            out[number[i], 0] = points[i, 0]
            out[number[i], 1] = points[i, 1]
            out[number[i], 2] = points[i, 2]
    faces = np.empty((len(triangles), 3), dtype=np.int32)
    row = 0
    for t in range(len(triangles)):
        whole = True
        for k in range(3):
            index = triangles[t, k]
            if index < 0 or index >= n:
                return out, faces[:0], index if index >= 0 else n
            faces[row, k] = number[index]
            whole = whole and number[index] >= 0
        if whole:
            row += 1
    return out, faces[:row], -1


@njit(cache=True, nogil=True)
def covered(
    pixels: NDArray[np.float64], triangles: NDArray[np.int32], width: int, height: int
) -> float:
    """Sum the pixels in the boxes around projected triangles: what drawing them costs.

    Parameters
    ----------
    pixels : (n, 2) float64
        Column and row of each point, px; a NaN makes its triangles count as one pixel.
    triangles : (m, 3) int32
        Indices into `pixels`.
    width, height : int
        Size of the image, px; boxes are clipped to it.

    Returns
    -------
    float
        Pixels.

    Examples
    --------
    >>> covered(np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 4.0]]), np.array([[0, 1, 2]]), 5, 5)
    25.0
    """
    total = 0.0
    for t in range(len(triangles)):
        area = 1.0
        for axis in range(2):
            a = pixels[triangles[t, 0], axis]
            b = pixels[triangles[t, 1], axis]
            c = pixels[triangles[t, 2], axis]
            last = (width if axis == 0 else height) - 1.0
            low, high = max(min(a, b, c), 0.0), min(max(a, b, c), last)
            area *= high - low + 1.0 if high > low else 1.0
        total += area
    return total
