"""Kernels of the normals by central differences: fused, NaN-aware, vectorised along rows."""

from __future__ import annotations

import numpy as np
from numba import njit

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}  # never nnan: NaN marks invalid pixels

_kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=_FASTMATH)
_inlined = njit(cache=True, nogil=True, error_model="numpy", inline="always")


@_inlined
def _or(value, fallback):  # type: ignore[no-untyped-def]
    """The value, or the fallback where it is NaN."""
    return value if value == value else fallback


@_inlined
def _pad(row, padded):  # type: ignore[no-untyped-def]
    """Copy a row between two NaN, so that the image ends as a hole begins."""
    padded[0] = np.nan
    for u in range(row.size):  # faster here than an assignment of slices
        padded[u + 1] = row[u]
    padded[-1] = np.nan


@_inlined
def _next_row(image, v, padded):  # type: ignore[no-untyped-def]
    """Padded copy of row v; all NaN beyond the image."""
    if v < image.shape[0]:
        _pad(image[v], padded)
    else:
        padded[:] = np.nan


@_inlined
def _scale(depth, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Inverse length of a direction; NaN where the depth is NaN."""
    scale = np.float32(1.0) / np.sqrt(nx * nx + ny * ny + nz * nz)
    return scale if depth == depth else depth


@_inlined
def _interleave(planes, row):  # type: ignore[no-untyped-def]
    """Planes (3, W) → row (W, 3): the arithmetic stays contiguous, hence vectorised."""
    flat, NX, NY, NZ = row.ravel(), planes[0], planes[1], planes[2]
    for u in range(NX.size):
        flat[3 * u] = NX[u]
        flat[3 * u + 1] = NY[u]
        flat[3 * u + 2] = NZ[u]


@_kernel
def from_points(points, normals):  # type: ignore[no-untyped-def]
    """Normals of points (n, H, W, 3)."""
    n, height, width, _ = points.shape
    du, dv = np.empty(3, np.float32), np.empty(3, np.float32)
    for i in range(n):
        for v in range(height):
            above, below = max(v - 1, 0), min(v + 1, height - 1)
            for u in range(width):
                left, right = max(u - 1, 0), min(u + 1, width - 1)
                for c in range(3):
                    p = points[i, v, u, c]
                    du[c] = _or(points[i, v, right, c], p) - _or(points[i, v, left, c], p)
                    dv[c] = _or(points[i, below, u, c], p) - _or(points[i, above, u, c], p)
                nx = dv[1] * du[2] - dv[2] * du[1]
                ny = dv[2] * du[0] - dv[0] * du[2]
                nz = dv[0] * du[1] - dv[1] * du[0]
                scale = _scale(points[i, v, u, 2], nx, ny, nz)
                normals[i, v, u, 0] = nx * scale
                normals[i, v, u, 1] = ny * scale
                normals[i, v, u, 2] = nz * scale


@_kernel
def from_pinhole(depth, fx, fy, cx, cy, normals):  # type: ignore[no-untyped-def]
    """Normals of depth (n, H, W), seen through focal lengths and principal point, px."""
    n, height, width = depth.shape
    zero, per_column, per_row = np.float32(0.0), np.float32(1.0 / fx), np.float32(1.0 / fy)
    above, here, below = np.empty((3, width + 2), np.float32)
    a, planes = np.empty(width, np.float32), np.empty((3, width), np.float32)
    NX, NY, NZ = planes
    for u in range(width):
        a[u] = (u - cx) / fx
    for i in range(n):
        above[:] = np.nan
        _pad(depth[i, 0], here)
        for v in range(height):
            _next_row(depth[i], v + 1, below)
            # the row and its neighbours, as views that one index walks
            west, centre, east, north, south = here, here[1:], here[2:], above[1:], below[1:]
            b = np.float32((v - cy) / fy)
            for u in range(width):
                z = centre[u]
                # with r = (a, b, 1): ∂p/∂u = D r + (X, 0, 0), ∂p/∂v = E r + (0, Y, 0);
                # a missing neighbour is replaced by the pixel itself, on its own ray
                X = per_column * (_or(west[u], zero) + _or(east[u], zero))
                Y = per_row * (_or(north[u], zero) + _or(south[u], zero))
                D, E = _or(east[u], z) - _or(west[u], z), _or(south[u], z) - _or(north[u], z)
                nx, ny = D * Y, E * X
                nz = -(a[u] * nx + b * ny + X * Y)
                scale = _scale(z, nx, ny, nz)
                NX[u], NY[u], NZ[u] = nx * scale, ny * scale, nz * scale
            _interleave(planes, normals[i, v])
            above, here, below = here, below, above


@_kernel
def from_orthographic(depth, pitch, normals):  # type: ignore[no-untyped-def]
    """Normals of depth (n, H, W) on square pixels."""
    n, height, width = depth.shape
    above, here, below = np.empty((3, width + 2), np.float32)
    planes = np.empty((3, width), np.float32)
    NX, NY, NZ = planes
    zero = np.float32(0.0)
    for i in range(n):
        above[:] = np.nan
        _pad(depth[i, 0], here)
        for v in range(height):
            _next_row(depth[i], v + 1, below)
            # the row and its neighbours, as views that one index walks
            west, centre, east, north, south = here, here[1:], here[2:], above[1:], below[1:]
            for u in range(width):
                z = centre[u]
                # ∂p/∂u = (X, 0, D), ∂p/∂v = (0, Y, E); a missing neighbour adds no length
                X = (pitch if west[u] == west[u] else zero) + (
                    pitch if east[u] == east[u] else zero
                )
                Y = (pitch if north[u] == north[u] else zero) + (
                    pitch if south[u] == south[u] else zero
                )
                D, E = _or(east[u], z) - _or(west[u], z), _or(south[u], z) - _or(north[u], z)
                nx, ny, nz = D * Y, E * X, -X * Y
                scale = _scale(z, nx, ny, nz)
                NX[u], NY[u], NZ[u] = nx * scale, ny * scale, nz * scale
            _interleave(planes, normals[i, v])
            above, here, below = here, below, above
