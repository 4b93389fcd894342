"""Points drawn as discs into a depth image."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError

_FAST = {"contract", "reassoc", "arcp", "nsz"}


@njit(cache=True, nogil=True, fastmath=_FAST)
def _draw(
    pixels: NDArray[np.float32],
    depth: NDArray[np.float32],
    radius: float,
    thickness: float,
    nearest: NDArray[np.float32],
    weight: NDArray[np.float32],
    total: NDArray[np.float32],
) -> None:
    height, width = nearest.shape
    for averaging in (False, True):
        for k in range(len(depth)):
            u, v, z = pixels[k, 0], pixels[k, 1], depth[k]
            if not (-radius < u < width + radius and -radius < v < height + radius):
                continue  # also where NaN
            for r in range(
                max(int(np.ceil(v - radius)), 0), min(int(np.floor(v + radius)), height - 1) + 1
            ):
                for c in range(
                    max(int(np.ceil(u - radius)), 0), min(int(np.floor(u + radius)), width - 1) + 1
                ):
                    d2 = (c - u) ** 2 + (r - v) ** 2
                    if d2 > radius * radius:
                        continue
                    if not averaging:
                        nearest[r, c] = min(nearest[r, c], z)
                    elif z <= nearest[r, c] + thickness:
                        # inverse square of the distance: a point on the centre decides alone
                        w = 1.0 / (d2 * d2 + 1e-6)
                        weight[r, c] += w
                        total[r, c] += w * (z - nearest[r, c])


def splat(
    pixels: ArrayLike,
    depth: ArrayLike,
    *,
    shape: tuple[int, int],
    radius_px: float,
    thickness_mm: float = 4.0,
) -> NDArray[np.float32]:
    r"""Depth image of a cloud: the nearest surface that a disc of each point covers.

    .. math:: Z = \sum_k w_k z_k / \sum_k w_k, \quad w_k = d_k^{-4}, \quad
        d_k \le r, \quad z_k \le \min_j z_j + t

    Parameters
    ----------
    pixels : (n, 2) array_like
        Column and row of each point, px.
    depth : (n,) array_like
        Depth of each point, mm, finite.
    shape : (int, int)
        Rows and columns of the image.
    radius_px : float
        Radius r of a disc, px, > 0; about the distance between neighbouring points.
    thickness_mm : float
        Depth t behind the nearest point that still belongs to the same surface, mm, ≥ 0.

    Returns
    -------
    (H, W) float32
        Depth, mm; NaN where no disc reaches a pixel's centre.

    Raises
    ------
    ParameterError
        A radius is not > 0 and finite, or a thickness < 0.

    Examples
    --------
    >>> splat([[1.0, 0.0], [1.0, 0.0]], [400.0, 500.0], shape=(1, 3), radius_px=0.5)
    array([[ nan, 400.,  nan]], dtype=float32)
    """
    if not (np.isfinite(radius_px) and radius_px > 0):
        raise ParameterError(f"radius_px must be > 0, got {radius_px}")
    if not thickness_mm >= 0:
        raise ParameterError(f"thickness_mm must be ≥ 0, got {thickness_mm}")
    nearest = np.full(shape, np.inf, dtype=np.float32)
    weight, total = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    _draw(
        np.asarray(pixels, np.float32),
        np.asarray(depth, np.float32),
        float(radius_px),
        float(thickness_mm),
        nearest,
        weight,
        total,
    )
    hit = weight > 0
    return np.where(hit, nearest + total / np.where(hit, weight, 1), np.nan).astype(np.float32)
