"""Where in a range image could a model's origin be: candidates, and the grid of poses to try."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rangeface.numerics.se3 import head_rotation


def rotation_grid(
    yaws_deg: Iterable[float], pitches_deg: Iterable[float], rolls_deg: Iterable[float]
) -> NDArray[np.float64]:
    """All combinations of head angles as rotations camera←face, (n, 3, 3).

    Parameters
    ----------
    yaws_deg, pitches_deg, rolls_deg : iterable of float
        Angles, degrees.

    Returns
    -------
    (n, 3, 3) float64

    Examples
    --------
    >>> rotation_grid([-15, 0, 15], [0], [0]).shape
    (3, 3, 3)
    """
    angles = np.deg2rad(list(product(yaws_deg, pitches_deg, rolls_deg)))
    return np.array([head_rotation(*a) for a in angles])


def pool(points: NDArray[np.float32], factor: int) -> NDArray[np.float32]:
    """Mean of the valid points of each factor × factor block, NaN where fewer than half are.

    Parameters
    ----------
    points : (H, W, 3) float32
        Organised points, NaN where invalid.
    factor : int
        Edge of a block, px, ≥ 1; rows and columns that fill no block are dropped.

    Returns
    -------
    (H // factor, W // factor, 3) float32
    """
    if factor == 1:
        return points
    height, width = points.shape[0] // factor, points.shape[1] // factor
    blocks = points[: height * factor, : width * factor].reshape(height, factor, width, factor, 3)
    valid = np.isfinite(blocks[..., 2])
    count = valid.sum(axis=(1, 3))
    sums = np.where(valid[..., None], blocks, 0.0).sum(axis=(1, 3), dtype=np.float64)
    enough = count >= (factor * factor + 1) // 2
    means = sums / np.maximum(count, 1)[..., None]
    return np.where(enough[..., None], means, np.nan).astype(np.float32)


def protrusions(
    points: NDArray[np.float32], rotations: NDArray[np.float64], *, radius_px: int
) -> NDArray[np.intp]:
    """Pixels that protrude furthest along a viewing axis within their neighbourhood.

    For every rotation, the pixels whose point lies furthest along the axis −z of the rotated
    frame among all within `radius_px`: for a face, with the head's own axis, the nose tip.

    Parameters
    ----------
    points : (H, W, 3) float32
        Organised points, NaN where invalid.
    rotations : (r, 3, 3) float64
        Rotations camera←face whose third column is the axis.
    radius_px : int
        Radius of the (square) neighbourhood.

    Returns
    -------
    (n, 2) intp
        Rows and columns, without repetition.
    """
    import cv2

    size = 2 * radius_px + 1
    window = np.ones((size, size), np.uint8)
    found = np.zeros(points.shape[:2], bool)
    for axis in np.unique(rotations[:, :, 2].round(9), axis=0):
        height = -(points @ axis.astype(np.float32))
        height = np.where(np.isfinite(height), height, np.float32(-1e9))
        highest = cv2.dilate(height, window, borderType=cv2.BORDER_CONSTANT, borderValue=-1e9)
        found |= (height == highest) & (height > -1e8)
    return np.argwhere(found)
