r"""Unit normals of organised range data.

Normals are in the camera frame (x right, y down, z forward) and point **towards the
camera**: of a surface seen head-on the normal is (0, 0, −1). On a grid whose columns run to
the right and whose rows run down this needs no flipping, because

.. math:: n \propto \frac{\partial p}{\partial v} \times \frac{\partial p}{\partial u}

faces the camera for every surface that the camera can see.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.numerics import localfit
from rangeface.numerics import normal_kernels as kernels
from rangeface.numerics.batches import as_batch

Float32: TypeAlias = NDArray[np.float32]


def from_points(points: ArrayLike) -> Float32:
    """Normals of organised points, by central differences.

    Parameters
    ----------
    points : (…, H, W, 3) array_like
        Points, any length unit, NaN where invalid.

    Returns
    -------
    (…, H, W, 3) float32
        Unit normals towards the camera; NaN where the point is invalid, or where along one
        of the two directions neither neighbour is valid.

    Notes
    -----
    Beside a hole or an edge of the image the difference is one-sided.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(3.0), np.arange(3.0))
    >>> from_points(np.stack([x, y, 5 + x], axis=-1))[1, 1].round(3)
    array([ 0.707,  0.   , -0.707], dtype=float32)
    """
    array = np.ascontiguousarray(points, dtype=np.float32)
    normals = np.empty_like(array)
    kernels.from_points(
        array.reshape(-1, *array.shape[-3:]), normals.reshape(-1, *array.shape[-3:])
    )
    return normals


def from_depth_orthographic(depth: ArrayLike, pitch: float) -> Float32:
    """Normals of an orthographic depth image, by central differences.

    Parameters
    ----------
    depth : (…, H, W) array_like
        Depth z, NaN where invalid.
    pitch : float
        Edge of a pixel, in the unit of the depth.

    Returns
    -------
    (…, H, W, 3) float32
        As `from_points` gives them for the back-projected points.

    Examples
    --------
    >>> from_depth_orthographic([[0, 2, 4], [0, 2, 4]], pitch=2.0)[0, 1].round(3) + 0.0
    array([ 0.707,  0.   , -0.707], dtype=float32)
    """
    batch, leading = as_batch(depth)
    normals = np.empty((*batch.shape, 3), np.float32)
    kernels.from_orthographic(batch, np.float32(pitch), normals)
    return normals.reshape(*leading, *normals.shape[1:])


def from_depth_pinhole(depth: ArrayLike, fx: float, fy: float, cx: float, cy: float) -> Float32:
    """Normals of a pinhole depth image, by central differences of its points.

    Parameters
    ----------
    depth : (…, H, W) array_like
        Depth z, NaN where invalid.
    fx, fy, cx, cy : float
        Focal lengths and principal point, px.

    Returns
    -------
    (…, H, W, 3) float32
        As `from_points` gives them for the back-projected points, which are never stored.

    Examples
    --------
    >>> from_depth_pinhole(np.full((3, 3), 400.0), 200, 200, 1, 1)[1, 1] + 0.0
    array([ 0.,  0., -1.], dtype=float32)
    """
    batch, leading = as_batch(depth)
    normals = np.empty((*batch.shape, 3), np.float32)
    kernels.from_pinhole(batch, float(fx), float(fy), float(cx), float(cy), normals)
    return normals.reshape(*leading, *normals.shape[1:])


def fit_orthographic(
    depth: ArrayLike,
    pitch: float,
    *,
    radius_px: float = 2.0,
    degree: int = 1,
    sigma: ArrayLike | None = None,
) -> Float32:
    r"""Normals of an orthographic depth image, by a local least-squares fit.

    .. math:: z ≈ c + p x + q y \;(+ \text{quadratic terms}), \quad n ∝ (p, q, -1)

    Parameters
    ----------
    depth : (…, H, W) array_like
        Depth z, NaN where invalid.
    pitch : float
        Edge of a pixel, in the unit of the depth.
    radius_px : float
        Radius of the window, px, ≥ 1.
    degree : {1, 2}
        Plane or quadric.
    sigma : (…, H, W) array_like, optional
        Standard deviation of the depth: residuals are weighted by 1/σ².

    Returns
    -------
    (…, H, W, 3) float32
        Unit normals towards the camera, NaN where the window determines none.

    Raises
    ------
    ParameterError
        A parameter of `localfit.fit` is out of range.

    Examples
    --------
    >>> tilted = np.add.outer(np.zeros(5), np.arange(5.0))
    >>> fit_orthographic(tilted, 1.0)[2, 2].round(3)
    array([ 0.707,  0.   , -0.707], dtype=float32)
    """
    fitted = localfit.fit(depth, sigma=sigma, radius_px=radius_px, degree=degree)
    return from_slopes(fitted[..., 1] / np.float32(pitch), fitted[..., 2] / np.float32(pitch))


def fit_pinhole(
    depth: ArrayLike,
    fx: float,
    fy: float,
    cx: float,
    cy: float,
    *,
    radius_px: float = 2.0,
    degree: int = 1,
    sigma: ArrayLike | None = None,
) -> Float32:
    r"""Normals of a pinhole depth image, by a local fit to the inverse depth.

    A plane n·p = d has the inverse depth :math:`1/z = (n/d) · (a, b, 1)`, linear in the pixel
    coordinates :math:`a = (u - c_x)/f_x, b = (v - c_y)/f_y`: the fit is exact on planes.

    Parameters
    ----------
    depth : (…, H, W) array_like
        Depth z > 0, NaN where invalid.
    fx, fy, cx, cy : float
        Focal lengths and principal point, px.
    radius_px, degree, sigma
        As for `fit_orthographic`.

    Returns
    -------
    (…, H, W, 3) float32
        Unit normals towards the camera, NaN where the window determines none.

    Raises
    ------
    ParameterError
        A parameter of `localfit.fit` is out of range.

    Examples
    --------
    >>> fit_pinhole(np.full((5, 5), 400.0), 200, 200, 2, 2)[2, 2].round(6) + 0.0
    array([ 0.,  0., -1.], dtype=float32)
    """
    z = np.asarray(depth, dtype=np.float32)
    inverse_sigma = None if sigma is None else np.asarray(sigma, np.float32) / (z * z)
    fitted = localfit.fit(1.0 / z, sigma=inverse_sigma, radius_px=radius_px, degree=degree)
    w, w_a, w_b = fitted[..., 0], fitted[..., 1] * np.float32(fx), fitted[..., 2] * np.float32(fy)
    height, width = z.shape[-2:]
    a = ((np.arange(width) - cx) / fx).astype(np.float32)
    b = ((np.arange(height) - cy) / fy).astype(np.float32)
    # n/d = (w_a, w_b, w − a w_a − b w_b); seen from the camera d < 0 along the outward normal
    normal = -np.stack([w_a, w_b, w - a * w_a - b[:, None] * w_b], axis=-1)
    return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True), dtype=np.float32)


def from_slopes(p: ArrayLike, q: ArrayLike) -> Float32:
    """Unit normals (…, 3) towards the camera of slopes p = ∂z/∂x and q = ∂z/∂y."""
    p, q = np.asarray(p, np.float32), np.asarray(q, np.float32)
    scale = 1.0 / np.sqrt(1.0 + p * p + q * q)
    return np.stack([p * scale, q * scale, -scale], axis=-1)


def covariance_of_slopes(p: ArrayLike, q: ArrayLike, slopes: ArrayLike) -> Float32:
    r"""Covariance of the unit normal from that of the slopes, to first order.

    .. math:: Σ_n = J Σ_{pq} J^T, \quad J = ∂n/∂(p, q)

    Parameters
    ----------
    p, q : (…) array_like
        Slopes ∂z/∂x and ∂z/∂y.
    slopes : (…, 2, 2) array_like
        Their covariance.

    Returns
    -------
    (…, 3, 3) float32
        Of rank 2: the normal cannot change its length.

    Examples
    --------
    >>> covariance_of_slopes(0.0, 0.0, np.diag([0.01, 0.04])).diagonal()
    array([0.01, 0.04, 0.  ], dtype=float32)
    """
    p, q = np.asarray(p, np.float64), np.asarray(q, np.float64)
    s = np.sqrt(1.0 + p * p + q * q)
    rows = [[1.0 + q * q, -p * q], [-p * q, 1.0 + p * p], [p, q]]
    J = np.stack([np.stack(np.broadcast_arrays(*row), axis=-1) for row in rows], axis=-2)
    J = J / s[..., None, None] ** 3
    return np.asarray(J @ np.asarray(slopes, np.float64) @ np.swapaxes(J, -1, -2), np.float32)
