"""Triangle z-buffer: a mesh in the camera frame to depth, normal and triangle per pixel.

Every pixel samples the surface at its centre, the integer coordinates (u, v). Inside a triangle
the depth is that of the triangle's plane along the pixel's ray, so planes come out exact in
both projections: for a pinhole 1/z is affine in the image, for parallel rays z is.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError

_NEAR_MM = 1e-3  # triangles that reach behind this depth are dropped, not clipped


def rasterise(
    points: ArrayLike,
    triangles: ArrayLike,
    *,
    focal_px: tuple[float, float],
    centre_px: tuple[float, float],
    size_px: tuple[int, int],
    perspective: bool,
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int32]]:
    r"""Nearest surface along every pixel's ray.

    .. math:: \frac{1}{z} = \sum_i λ_i(u, v) \frac{1}{z_i} \quad\text{(pinhole)}, \qquad
              z = \sum_i λ_i(u, v) z_i \quad\text{(parallel rays)}

    with the barycentric coordinates λ of the pixel centre in the projected triangle.

    Parameters
    ----------
    points : (n, 3) array_like
        Vertices in the camera frame, mm (x right, y down, z forward).
    triangles : (m, 3) array_like of int
        Indices into `points`, any orientation.
    focal_px : tuple of float
        Pinhole: fx, fy in px. Parallel rays: px per mm. Not zero.
    centre_px : tuple of float
        Principal point cx, cy, px.
    size_px : tuple of int
        Width and height, px.
    perspective : bool
        Pinhole (True) or parallel rays (False).

    Returns
    -------
    depth : (H, W) float32
        z, mm; NaN where nothing is seen.
    normal : (H, W, 3) float32
        Unit normal of the triangle, turned towards the camera; NaN where nothing is seen.
    triangle : (H, W) int32
        Index of the triangle; −1 where nothing is seen.

    Raises
    ------
    ParameterError
        A focal length is zero or not finite, or a size is below 1 px.

    Notes
    -----
    A triangle with a vertex behind the camera is left out. On a tie the first triangle wins, so
    the result depends on nothing but the input. 27,000 triangles at 176 × 144 take about 1 ms.

    Examples
    --------
    >>> corners = [[-3.0, -3.0, 100.0], [3.0, -3.0, 100.0], [0.0, 3.0, 100.0]]
    >>> depth, normal, triangle = rasterise(corners, [[0, 1, 2]], focal_px=(50.0, 50.0),
    ...                                     centre_px=(2.0, 2.0), size_px=(5, 5), perspective=True)
    >>> depth[1]
    array([ nan, 100., 100., 100.,  nan], dtype=float32)
    >>> normal[2, 2] + 0.0
    array([ 0.,  0., -1.], dtype=float32)
    """
    if not all(np.isfinite(f) and f != 0 for f in focal_px):
        raise ParameterError(f"focal_px: must be finite and not 0, got {focal_px}")
    width, height = size_px
    if width < 1 or height < 1:
        raise ParameterError(f"size_px: must be at least 1 × 1 px, got {size_px}")
    vertices = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
    corners = np.ascontiguousarray(triangles, dtype=np.int32).reshape(-1, 3)
    projected = _project(vertices, *focal_px, *centre_px, perspective)
    depth, triangle = _fill(projected, corners, width, height, perspective)
    normal = _normals(vertices, corners, triangle, *focal_px, *centre_px, perspective)
    return depth, normal, triangle


@njit(cache=True, nogil=True, error_model="numpy")
def _project(
    points: NDArray[np.float64], fx: float, fy: float, cx: float, cy: float, perspective: bool
) -> NDArray[np.float64]:
    # rows u, v, w: w is what is affine in the image (1/z or z); NaN behind a pinhole
    out = np.empty_like(points)
    for i in range(points.shape[0]):
        x, y, z = points[i]
        if not perspective:
            out[i, 0], out[i, 1], out[i, 2] = x * fx + cx, y * fy + cy, z
        elif z > _NEAR_MM:
            out[i, 0], out[i, 1], out[i, 2] = x / z * fx + cx, y / z * fy + cy, 1.0 / z
        else:
            out[i, :] = np.nan
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _fill(
    projected: NDArray[np.float64],
    triangles: NDArray[np.int32],
    width: int,
    height: int,
    perspective: bool,
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    # nearest = largest 1/z or smallest z: `key` is negated for the pinhole so that less is nearer
    sign = -1.0 if perspective else 1.0
    key = np.full((height, width), np.inf)
    owner = np.full((height, width), -1, np.int32)
    for t in range(triangles.shape[0]):
        a, b, c = projected[triangles[t, 0]], projected[triangles[t, 1]], projected[triangles[t, 2]]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if not abs(area) > 0.0:  # degenerate, or behind the camera (NaN)
            continue
        left = max(0, int(np.ceil(min(a[0], b[0], c[0]))))
        right = min(width - 1, int(np.floor(max(a[0], b[0], c[0]))))
        top = max(0, int(np.ceil(min(a[1], b[1], c[1]))))
        bottom = min(height - 1, int(np.floor(max(a[1], b[1], c[1]))))
        inverse = 1.0 / area
        for v in range(top, bottom + 1):
            for u in range(left, right + 1):
                beta = ((u - a[0]) * (c[1] - a[1]) - (v - a[1]) * (c[0] - a[0])) * inverse
                gamma = ((b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0])) * inverse
                if beta < 0.0 or gamma < 0.0 or beta + gamma > 1.0:
                    continue
                w = sign * (a[2] + beta * (b[2] - a[2]) + gamma * (c[2] - a[2]))
                if w < key[v, u]:
                    key[v, u] = w
                    owner[v, u] = t
    depth = np.full((height, width), np.nan, np.float32)
    for v in range(height):
        for u in range(width):
            if owner[v, u] >= 0:
                depth[v, u] = -1.0 / key[v, u] if perspective else key[v, u]
    return depth, owner


@njit(cache=True, nogil=True, error_model="numpy")
def _normals(
    points: NDArray[np.float64],
    triangles: NDArray[np.int32],
    owner: NDArray[np.int32],
    fx: float,
    fy: float,
    cx: float,
    cy: float,
    perspective: bool,
) -> NDArray[np.float32]:
    height, width = owner.shape
    normal = np.full((height, width, 3), np.nan, np.float32)
    for v in range(height):
        for u in range(width):
            t = owner[v, u]
            if t < 0:
                continue
            a, b, c = points[triangles[t, 0]], points[triangles[t, 1]], points[triangles[t, 2]]
            p0, p1, p2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
            q0, q1, q2 = c[0] - a[0], c[1] - a[1], c[2] - a[2]
            n0, n1, n2 = p1 * q2 - p2 * q1, p2 * q0 - p0 * q2, p0 * q1 - p1 * q0
            along = n2
            if perspective:  # the ray of the pixel decides which side is seen
                along += n0 * (u - cx) / fx + n1 * (v - cy) / fy
            scale = 1.0 / np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            if along > 0.0:
                scale = -scale
            normal[v, u, 0], normal[v, u, 1], normal[v, u, 2] = n0 * scale, n1 * scale, n2 * scale
    return normal
