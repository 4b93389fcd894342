"""Surfaces in closed form: walls and balls."""

from __future__ import annotations

import numpy as np

from rangeface.errors import ParameterError
from rangeface.types import PointSet


def wall(depth_mm: float, *, half_mm: float = 3000.0) -> PointSet:
    """A square wall across the optical axis.

    Parameters
    ----------
    depth_mm : float
        Its depth, mm, > 0.
    half_mm : float
        Half of its edge, mm, > 0.

    Returns
    -------
    PointSet
        In the camera frame, two triangles.

    Raises
    ------
    ParameterError
        A length is not positive.

    Examples
    --------
    >>> wall(1000.0).points[0]
    array([-3000., -3000.,  1000.], dtype=float32)
    """
    for name, value in (("depth_mm", depth_mm), ("half_mm", half_mm)):
        if not value > 0:
            raise ParameterError(f"{name}: must be > 0, got {value}")
    x = half_mm * np.array([-1.0, 1.0, 1.0, -1.0])
    y = half_mm * np.array([-1.0, -1.0, 1.0, 1.0])
    corners = np.stack([x, y, np.full(4, depth_mm)], axis=-1)
    return PointSet(corners.astype(np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def ball(
    radius_mm: float, centre_mm: tuple[float, float, float] = (0.0, 0.0, 0.0), *, rings: int = 64
) -> PointSet:
    """A ball as a mesh of `rings` rings of latitude.

    Parameters
    ----------
    radius_mm : float
        Radius, mm, > 0.
    centre_mm : tuple of float
        Centre, mm.
    rings : int
        ≥ 3; the mesh lies at most radius · (1 − cos(π / 2 rings)) inside the ball.

    Returns
    -------
    PointSet
        Vertices on the sphere.

    Raises
    ------
    ParameterError
        The radius is not positive, or there are fewer than three rings.
    """
    if not radius_mm > 0:
        raise ParameterError(f"radius_mm: must be > 0, got {radius_mm}")
    if rings < 3:
        raise ParameterError(f"rings: at least 3, got {rings}")
    around = 2 * rings
    polar = np.linspace(0.0, np.pi, rings + 1)[:, None]
    azimuth = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)[None, :]
    unit = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
         np.cos(polar) + 0.0 * azimuth], axis=-1,
    )  # fmt: skip
    first = np.arange(rings * around).reshape(rings, around)
    right = np.roll(first, -1, axis=1)
    triangles = np.concatenate([
        np.stack([first, right, first + around], -1).reshape(-1, 3),
        np.stack([right, right + around, first + around], -1).reshape(-1, 3),
    ])  # fmt: skip
    points = radius_mm * unit.reshape(-1, 3) + np.array(centre_mm)
    return PointSet(points.astype(np.float32), triangles.astype(np.int32))
