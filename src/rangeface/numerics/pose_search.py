"""Where in a range image could a model's origin be: candidates, and the grid of poses to try."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.numerics.projection import Projection
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


def pool(depth: NDArray[np.float32], projection: Projection, factor: int) -> NDArray[np.float32]:
    """Organised points of a depth image, one for each factor × factor block.

    Parameters
    ----------
    depth : (H, W) float32
        mm, NaN where invalid.
    projection : Projection
        Of the image's camera.
    factor : int
        Edge of a block, px, ≥ 1; rows and columns that fill no block are dropped.

    Returns
    -------
    (H // factor, W // factor, 3) float32
        Mean depth of the valid pixels on the ray through their centre; NaN where fewer than
        half are valid.
    """
    return _pool(depth, tuple(projection), factor)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def _pool(depth, projection, factor):  # type: ignore[no-untyped-def]
    perspective, sx, sy, cx, cy = projection
    height, width = depth.shape[0] // factor, depth.shape[1] // factor
    out = np.full((height, width, 3), np.nan, np.float32)
    enough = (factor * factor + 1) // 2
    for i in range(height):
        for j in range(width):
            count, u, v, z = 0, 0, 0, 0.0
            for row in range(i * factor, (i + 1) * factor):
                for col in range(j * factor, (j + 1) * factor):
                    d = depth[row, col]
                    if d == d:
                        count, u, v, z = count + 1, u + col, v + row, z + d
            if count < enough:
                continue
            z /= count
            scale = z if perspective else 1.0
            out[i, j, 0] = (u / count - cx) / sx * scale
            out[i, j, 1] = (v / count - cy) / sy * scale
            out[i, j, 2] = z
    return out


def protrusions(
    points: NDArray[np.float32], rotations: NDArray[np.float64], *, radius_px: int
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
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
    pixels : (n, 2) intp
        Rows and columns, without repetition.
    along : (n, r) bool
        Along which rotation's axis each of them protrudes.
    """
    import cv2

    size = 2 * radius_px + 1
    window = np.ones((size, size), np.uint8)
    axes, axis_of = np.unique(rotations[:, :, 2].round(9), axis=0, return_inverse=True)
    found = np.empty((*points.shape[:2], len(axes)), bool)
    for k, axis in enumerate(axes):
        height = -(points @ axis.astype(np.float32))
        height = np.where(np.isfinite(height), height, np.float32(-1e9))
        highest = cv2.dilate(height, window, borderType=cv2.BORDER_CONSTANT, borderValue=-1e9)
        found[..., k] = (height == highest) & (height > -1e8)
    pixels = np.argwhere(found.any(axis=2))
    return pixels, found[pixels[:, 0], pixels[:, 1]][:, axis_of.ravel()]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def within(points, centre, radius):  # type: ignore[no-untyped-def]
    """Which points lie within a sphere.

    Parameters
    ----------
    points : (H, W, 3) float32
        mm, NaN where invalid.
    centre : (3,) float64
        mm.
    radius : float
        mm.

    Returns
    -------
    (H, W) bool
        False where invalid.
    """
    out = np.empty(points.shape[:2], np.bool_)
    for i in range(points.shape[0]):
        for j in range(points.shape[1]):
            x = points[i, j, 0] - centre[0]
            y = points[i, j, 1] - centre[1]
            z = points[i, j, 2] - centre[2]
            out[i, j] = x * x + y * y + z * z <= radius * radius
    return out
