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
from math import ceil, inf
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import pattern_kernels as kernels
from rangeface.numerics.batches import as_batch

Float32: TypeAlias = NDArray[np.float32]

POINTS = (8, 16, 24)
"""Numbers of neighbours that the operators take."""

METHODS = {"basic": 0, "u2": 1, "ri": 2, "riu2": 3}
"""Label maps of a code, and their number in the kernels."""

_NO_LABELS = np.empty((0, 0, 0), np.float32)


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
    side, table = _operator(points, radius_px, method)
    batch, leading = _batch_of(images, side)
    labels = np.empty(batch.shape, np.float32)
    if points == 8 and radius_px == 1:
        kernels.lbp_eight(batch, table, labels)
    else:
        kernels.lbp(batch, *_circle(points, float(radius_px)), table, METHODS[method], labels)
    return labels.reshape(leading + batch.shape[1:]) if leading else labels[0]


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
    side, table = _operator(8, radius_px, "basic")
    batch, leading = _batch_of(images, side)
    layers = np.empty((len(batch), 4, *batch.shape[1:]), np.float32)
    if radius_px == 1:
        kernels.tdlbp_eight(batch, _per_unit(unit), table, _NO_LABELS, layers)
    else:
        kernels.tdlbp(batch, *_circle(8, float(radius_px)), _per_unit(unit), layers)
    return layers.reshape(leading + layers.shape[1:]) if leading else layers[0]


def lbp_and_tdlbp(
    images: ArrayLike, *, method: str = "riu2", unit: float = 1.0
) -> tuple[Float32, Float32]:
    """`lbp` and `tdlbp` of the eight neighbours at 1 px, in one pass.

    Parameters
    ----------
    images : (…, H, W) array_like
        Values, NaN where invalid.
    method : {"basic", "u2", "ri", "riu2"}
        Label of a code, as for `lbp`.
    unit : float
        The unit of a difference, as for `tdlbp`.

    Returns
    -------
    labels : (…, H, W) float32
    layers : (…, 4, H, W) float32
        Bit for bit what the two functions give.

    Raises
    ------
    ParameterError
        As the two functions raise it.

    Examples
    --------
    >>> labels, layers = lbp_and_tdlbp(np.eye(5))
    >>> bool((labels == lbp(np.eye(5))).all() and (layers == tdlbp(np.eye(5))).all())
    True
    """
    side, table = _operator(8, 1.0, method)
    batch, leading = _batch_of(images, side)
    labels = np.empty(batch.shape, np.float32)
    layers = np.empty((len(batch), 4, *batch.shape[1:]), np.float32)
    kernels.tdlbp_eight(batch, _per_unit(unit), table, labels, layers)
    if not leading:
        return labels[0], layers[0]
    return labels.reshape(leading + batch.shape[1:]), layers.reshape(leading + layers.shape[1:])


def check(points: int, radius_px: float, method: str) -> None:
    """Raise ParameterError where P, R or the method is outside its range."""
    if points not in POINTS:
        raise ParameterError(f"points: P must be one of {POINTS}, got {points}")
    if method not in METHODS:
        raise ParameterError(f"method: must be one of {sorted(METHODS)}, got {method!r}")
    if not 0 < radius_px < inf:
        raise ParameterError(f"radius_px: must be > 0 px, got {radius_px}")


def _batch_of(images: ArrayLike, side: int) -> tuple[Float32, tuple[int, ...]]:
    """`as_batch`, with a short way for one image: its call costs as much as a small image."""
    image = np.ascontiguousarray(images, np.float32)
    if image.ndim == 2 and min(image.shape) >= side:
        return image[None], ()
    return as_batch(image, at_least=side)


def _per_unit(unit: float) -> np.float32:
    """Units in a value of 1."""
    if not 0 < unit < inf:
        raise ParameterError(f"unit: must be > 0, got {unit}")
    return np.float32(1.0 / unit)


@lru_cache(maxsize=64)
def _operator(points: int, radius_px: float, method: str) -> tuple[int, Float32]:
    """Side, px, of the neighbourhood, and the label of every code; checks P, R and method."""
    check(points, radius_px, method)
    return 2 * ceil(radius_px) + 1, _label_table(points, method)


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
    kernels.fill_labels(table, points, METHODS[method])
    return table
