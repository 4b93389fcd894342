"""The camera behind an organised cloud."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError
from rangeface.types import Pinhole


def fit_pinhole(points: NDArray[np.float32], *, max_error_px: float = 0.5) -> Pinhole | None:
    r"""Pinhole camera whose pixel grid an organised cloud is, None if it is none.

    .. math:: u = f_x x / z + c_x, \quad v = f_y y / z + c_y

    by least squares over the valid points (H, W, 3) in the camera frame; accepted where 95 %
    of them lie within `max_error_px` of their pixel.
    """
    height, width = points.shape[:2]
    valid = np.isfinite(points).all(axis=2) & (points[..., 2] > 0)
    rows, columns = np.nonzero(valid)
    if len(rows) < 16:
        return None
    x, y, z = points[valid].astype(np.float64).T
    fits = [_line(x / z, columns), _line(y / z, rows)]
    if any(fit is None for fit in fits):
        return None
    (fx, cx, error_u), (fy, cy, error_v) = (fit for fit in fits if fit is not None)
    if np.quantile(np.maximum(error_u, error_v), 0.95) > max_error_px:
        return None
    if not (min(fx, fy) >= 1e-3 and max(fx, fy, abs(cx), abs(cy)) <= 1e6):
        return None
    try:
        return Pinhole(fx, fy, cx, cy, width, height)
    except ParameterError:
        return None


def _line(
    slope: NDArray[np.float64], pixel: NDArray[np.int64]
) -> tuple[float, float, NDArray[np.float64]] | None:
    """Focal length, principal point and errors of pixel = f · slope + c."""
    spread = slope - slope.mean()
    variance = float(spread @ spread)
    if not variance > 1e-12:
        return None
    f = float(spread @ (pixel - pixel.mean())) / variance
    c = float(pixel.mean() - f * slope.mean())
    return f, c, np.abs(f * slope + c - pixel)
