r"""Local binary patterns and 3-D local binary patterns.

The neighbours of a pixel lie on a circle, number k at :math:`R(\cos 2πk/P, \sin 2πk/P)` from
it: number 0 to the right, the others clockwise as displayed (rows run down). Bit k of a code
belongs to neighbour k:

.. math:: b_k = [d_k ≥ 0], \qquad d_k = \sum_t w_t (f_t - f_c)

with the bilinear weights w of the four pixels around the neighbour (coordinates rounded to
1e-5 px, so that neighbours which mean to be whole pixels are). The difference is taken before
the interpolation: a tie on a flat patch is an exact tie, and codes as 1. A neighbour that is
missing (a hole, or beyond the image) counts as level with the centre, that is as a tie; a
missing centre gives the code of a flat patch.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.numerics.batches import as_batch

Float32: TypeAlias = NDArray[np.float32]

POINTS = (8, 16, 24)
"""Numbers of neighbours that the operators take."""

METHODS = {"basic": 0, "u2": 1, "ri": 2, "riu2": 3}
"""Label maps of a code, and their number in the kernels."""


def label_count(points: int, method: str) -> int:
    """Number of different labels that a method gives.

    Parameters
    ----------
    points : {8, 16, 24}
        Number of neighbours P.
    method : {"basic", "u2", "ri", "riu2"}
        Label map.

    Returns
    -------
    int
        2^P, P(P−1) + 3, 2^P (labels are minimal codes, not numbered through) or P + 2.

    Raises
    ------
    ParameterError
        P or the method is unknown.

    Examples
    --------
    >>> [label_count(8, m) for m in ("basic", "u2", "ri", "riu2")]
    [256, 59, 256, 10]
    """
    check(points, 1.0, method)
    counts = {"u2": points * (points - 1) + 3, "riu2": points + 2}
    return counts.get(method, 2**points)


def lbp(
    images: ArrayLike, *, points: int = 8, radius_px: float = 1.0, method: str = "riu2"
) -> Float32:
    """Local binary patterns LBP_{P,R}.

    Parameters
    ----------
    images : (…, H, W) array_like
        Values (greater = nearer, for a range image as the paper displays it), NaN where
        invalid.
    points : {8, 16, 24}
        Number of neighbours P.
    radius_px : float
        Radius R of the circle, px, > 0.
    method : {"basic", "u2", "ri", "riu2"}
        Label of a code: the code itself; uniform codes by number of ones and rotation
        (1 + (ones − 1) P + rotation, where `rotation` is the neighbour at which the run of
        ones begins) and all others as P(P−1) + 2; the smallest rotation of the code; its
        number of ones if it is uniform, else P + 1. Uniform: at most two changes of bit
        around the circle.

    Returns
    -------
    (…, H, W) float32
        Labels 0 … `label_count` − 1, finite everywhere.

    Raises
    ------
    ParameterError
        P or the method is unknown, the radius is not positive, or the image is smaller than
        the neighbourhood.

    References
    ----------
    T. Ojala, M. Pietikäinen, T. Mäenpää, IEEE TPAMI 24(7), 2002,
    doi:10.1109/TPAMI.2002.1017623, eq. 3–13.

    Examples
    --------
    A peak, where every neighbour is lower, and a flat patch:

    >>> peak = np.zeros((3, 3))
    >>> lbp(peak)[1, 1]
    np.float32(8.0)
    >>> peak[1, 1] = 1.0
    >>> lbp(peak)[1, 1]
    np.float32(0.0)
    """
    check(points, radius_px, method)
    batch, leading = as_batch(images, at_least=2 * int(np.ceil(radius_px)) + 1)
    labels = np.empty_like(batch)
    offsets, weights = _circle(points, float(radius_px))
    _lbp(batch, offsets, weights, _label_table(points, method), METHODS[method], labels)
    return labels.reshape(*leading, *batch.shape[1:])


def tdlbp(images: ArrayLike, *, radius_px: float = 1.0, unit: float = 1.0) -> Float32:
    r"""3-D local binary patterns: the sign and the size of the differences, in four layers.

    The size of a difference is rounded to whole units (halves up) and cut at 7; its three
    binary digits and the sign give four bits a neighbour, and four codes a pixel:

    .. math:: L_1 = \sum_k [d_k ≥ 0]\, 2^k, \qquad
              \min(7, ⌊|d_k| / u + ½⌋) = (b_2 b_3 b_4)_2, \qquad L_i = \sum_k b_{i,k} 2^k

    Parameters
    ----------
    images : (…, H, W) array_like
        Values, NaN where invalid.
    radius_px : float
        Radius of the circle of eight neighbours, px, > 0.
    unit : float
        The unit u of a difference, in the unit of the values, > 0.

    Returns
    -------
    (…, 4, H, W) float32
        Layers 1 to 4, codes 0 … 255, finite everywhere.

    Raises
    ------
    ParameterError
        The radius or the unit is not positive, or the image is smaller than the
        neighbourhood.

    References
    ----------
    Y. Huang, Y. Wang, T. Tan, "Combining statistics of geometrical features learned by
    AdaBoost for 3D face recognition by local binary patterns", BMVC 2006,
    doi:10.5244/C.20.90.

    Examples
    --------
    Neighbour 0 (right) is 5 = 101₂ units higher, neighbour 4 (left) 2 = 010₂ lower:

    >>> tdlbp([[0, 0, 0], [-2, 0, 5], [0, 0, 0]])[:, 1, 1]
    array([199.,   1.,  16., 131.], dtype=float32)
    """
    check(8, radius_px, "basic")
    if not (np.isfinite(unit) and unit > 0):
        raise ParameterError(f"unit: must be > 0, got {unit}")
    batch, leading = as_batch(images, at_least=2 * int(np.ceil(radius_px)) + 1)
    offsets, weights = _circle(8, float(radius_px))
    layers = np.empty((batch.shape[0], 4, *batch.shape[1:]), np.float32)
    _tdlbp(batch, offsets, weights, np.float32(1.0 / unit), layers)
    return layers.reshape(*leading, *layers.shape[1:])


def check(points: int, radius_px: float, method: str) -> None:
    """Raise ParameterError where P, R or the method is outside its range."""
    if points not in POINTS:
        raise ParameterError(f"points: P must be one of {POINTS}, got {points}")
    if method not in METHODS:
        raise ParameterError(f"method: must be one of {sorted(METHODS)}, got {method!r}")
    if not (np.isfinite(radius_px) and radius_px > 0):
        raise ParameterError(f"radius_px: must be > 0 px, got {radius_px}")


@lru_cache(maxsize=64)
def _circle(points: int, radius_px: float) -> tuple[NDArray[np.int64], Float32]:
    """Pixels (P, 4, 2: row, column) around every neighbour, and their bilinear weights (P, 4)."""
    angle = 2.0 * np.pi * np.arange(points) / points
    across = np.round(radius_px * np.cos(angle), 5)
    down = np.round(radius_px * np.sin(angle), 5)
    row, column = np.floor(down), np.floor(across)
    t, s = down - row, across - column
    corners = [(0, 0), (0, 1), (1, 0), (1, 1)]
    offsets = np.stack([np.stack([row + r, column + c], axis=-1) for r, c in corners], axis=1)
    weights = np.stack([(t if r else 1 - t) * (s if c else 1 - s) for r, c in corners], axis=1)
    # a corner without weight repeats the heaviest one, lest a hole there be felt
    heaviest = np.take_along_axis(offsets, weights.argmax(axis=1)[:, None, None], axis=1)
    offsets = np.where(weights[..., None] > 0, offsets, heaviest)
    return offsets.astype(np.int64), weights.astype(np.float32)


@lru_cache(maxsize=16)
def _label_table(points: int, method: str) -> Float32:
    """Label of every code; empty for P = 24, whose labels are computed pixel by pixel."""
    if points > 16:
        return np.empty(0, np.float32)
    table = np.empty(2**points, np.float32)
    _fill_labels(table, points, METHODS[method])
    return table


# ── kernels ──────────────────────────────────────────────────────────────────────────────


@njit(cache=True, nogil=True)
def _label(code, points, method):  # type: ignore[no-untyped-def]
    if method == 0:
        return code
    everything = (1 << points) - 1
    if method == 2:
        smallest, turned = code, code
        for _ in range(points - 1):
            turned = (turned >> 1) | ((turned & 1) << (points - 1))
            smallest = min(smallest, turned)
        return smallest
    # bit k of `starts`: the run of ones begins at neighbour k
    starts = code & ~((code << 1) | (code >> (points - 1))) & everything
    ones = 0
    for k in range(points):
        ones += (code >> k) & 1
    uniform = (starts & (starts - 1)) == 0
    if method == 3:
        return ones if uniform else points + 1
    if not uniform:
        return points * (points - 1) + 2
    if ones == 0:
        return 0
    if ones == points:
        return points * (points - 1) + 1
    rotation = 0
    while (starts >> rotation) & 1 == 0:
        rotation += 1
    return 1 + (ones - 1) * points + rotation


@njit(cache=True, nogil=True)
def _fill_labels(table, points, method):  # type: ignore[no-untyped-def]
    for code in range(table.size):
        table[code] = _label(code, points, method)


@njit(cache=True, nogil=True)
def _frame(image, margin, framed):  # type: ignore[no-untyped-def]
    """Copy the image into a frame of NaN: beyond its edge everything is missing."""
    height, width = image.shape
    framed[:] = np.nan
    framed[margin : margin + height, margin : margin + width] = image


@njit(cache=True, nogil=True)
def _difference(framed, margin, offsets, weights, d):  # type: ignore[no-untyped-def]
    """Interpolated differences between one neighbour and the centre, over the whole image."""
    stride, flat, length = framed.shape[1], framed.ravel(), d.size
    first = margin * (stride + 1)
    shift = first + offsets[:, 0] * stride + offsets[:, 1]
    centre = flat[first : first + length]
    tap0, tap1 = flat[shift[0] : shift[0] + length], flat[shift[1] : shift[1] + length]
    tap2, tap3 = flat[shift[2] : shift[2] + length], flat[shift[3] : shift[3] + length]
    w0, w1, w2, w3 = weights
    if max(w0, w1, w2, w3) == 1:
        for x in range(length):
            d[x] = tap0[x] - centre[x]
    else:
        for x in range(length):
            c = centre[x]
            d[x] = w0 * (tap0[x] - c) + w1 * (tap1[x] - c) + w2 * (tap2[x] - c) + w3 * (tap3[x] - c)


@njit(cache=True, nogil=True)
def _lbp(images, offsets, weights, table, method, labels):  # type: ignore[no-untyped-def]
    n, height, width = images.shape
    points = len(offsets)
    margin = np.abs(offsets).max()
    framed = np.empty((height + 2 * margin, width + 2 * margin), np.float32)
    stride = framed.shape[1]
    d = np.empty((height - 1) * stride + width, np.float32)
    codes = np.empty(d.size, np.int32)
    for i in range(n):
        _frame(images[i], margin, framed)
        codes[:] = 0
        for k in range(points):
            _difference(framed, margin, offsets[k], weights[k], d)
            bit = np.int32(1 << k)
            for x in range(d.size):
                # not (d < 0) is also true of NaN: missing is level
                codes[x] |= np.int32(0) if d[x] < 0 else bit
        for v in range(height):
            row, label = codes[v * stride : v * stride + width], labels[i, v]
            if table.size:
                for u in range(width):
                    label[u] = table[row[u]]
            else:
                for u in range(width):
                    label[u] = _label(np.int64(row[u]), points, method)


@njit(cache=True, nogil=True)
def _tdlbp(images, offsets, weights, per_unit, layers):  # type: ignore[no-untyped-def]
    n, height, width = images.shape
    margin = np.abs(offsets).max()
    framed = np.empty((height + 2 * margin, width + 2 * margin), np.float32)
    stride = framed.shape[1]
    d = np.empty((height - 1) * stride + width, np.float32)
    codes = np.empty(d.size, np.int32)  # four bytes: the codes of the four layers
    half, seven = np.float32(0.5), np.float32(7.0)
    for i in range(n):
        _frame(images[i], margin, framed)
        codes[:] = 0
        for k in range(8):
            _difference(framed, margin, offsets[k], weights[k], d)
            for x in range(d.size):
                units = abs(d[x]) * per_unit + half
                units = units if units < seven else (seven if units >= seven else half)
                size = np.int32(units)
                sign = np.int32(0) if d[x] < 0 else np.int32(1)
                bits = sign | (size & 4) << 6 | (size & 2) << 15 | (size & 1) << 24
                codes[x] |= np.int32(bits << k)
        for layer in range(4):
            for v in range(height):
                row, target = codes[v * stride : v * stride + width], layers[i, layer, v]
                for u in range(width):
                    target[u] = np.float32((row[u] >> (8 * layer)) & 255)
