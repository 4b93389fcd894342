"""What stands before a camera and is no face: shoulders, hands, cushions."""

from __future__ import annotations

import numpy as np

from rangeface.errors import ParameterError
from rangeface.types import Float64, PointSet

_AROUND, _ALONG = 96, 64


def shoulders(*, folds_mm: float = 3.0, rng: np.random.Generator) -> PointSet:
    """Neck and chest of a clothed person whose head is out of the picture.

    Parameters
    ----------
    folds_mm : float
        Root mean square of the folds of the cloth, mm, ≥ 0.
    rng : numpy.random.Generator
        Source of the build and of the folds.

    Returns
    -------
    PointSet
        The pit of the neck is near the origin; y down, the back is further in z.

    Raises
    ------
    ParameterError
        `folds_mm` is negative.
    """
    _not_negative("folds_mm", folds_mm)
    neck, broad, deep = rng.uniform([48.0, 170.0, 85.0], [65.0, 230.0, 120.0])
    slope = rng.uniform(25.0, 60.0)
    y = np.linspace(-90.0, 320.0, _ALONG)[:, None]
    rise = 1.0 / (1.0 + np.exp(-(y - slope) / rng.uniform(12.0, 22.0)))
    half_x, half_z = neck + (broad - neck) * rise, neck + (deep - neck) * rise
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND)[None, :]
    x, z = half_x * np.sin(angle), neck - half_z * np.cos(angle)
    points = np.stack([x, y + 0.0 * angle, z], axis=-1)
    points[..., 2] += folds_mm * _waves(points, 25.0, 90.0, rng) * rise
    return _grid(points)


def cushion(*, wrinkles_mm: float = 2.0, rng: np.random.Generator) -> PointSet:
    """A cushion of a face's size or larger, with wrinkles.

    Parameters
    ----------
    wrinkles_mm : float
        Root mean square of the wrinkles, mm, ≥ 0.
    rng : numpy.random.Generator
        Source of its form.

    Returns
    -------
    PointSet
        Its middle is the origin, its broad sides face along z.

    Raises
    ------
    ParameterError
        `wrinkles_mm` is negative.
    """
    _not_negative("wrinkles_mm", wrinkles_mm)
    half_x, half_y, half_z = rng.uniform([80.0, 80.0, 35.0], [240.0, 240.0, 110.0])
    power = rng.uniform(0.4, 1.0)
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND)[None, :]
    polar = np.linspace(0.0, np.pi, _ALONG)[:, None]
    ring = np.sin(polar) ** power
    points = np.stack(
        [half_x * ring * _soft(np.cos(angle), power), half_y * ring * _soft(np.sin(angle), power),
         -half_z * np.cos(polar) + 0.0 * angle], axis=-1,
    )  # fmt: skip
    points[..., 2] += wrinkles_mm * _waves(points, 30.0, 120.0, rng)
    return _grid(points)


def hand(*, rng: np.random.Generator) -> PointSet:
    """An open or half-closed hand, palm or back towards −z.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of its size, the spread of the fingers and their bend.

    Returns
    -------
    PointSet
        The middle of the palm is the origin, the fingers point to −y.
    """
    size, bend, spread = rng.uniform([0.85, -0.3, 0.0], [1.2, 1.3, 0.25])
    parts = [_capsule((0.0, 25.0, 0.0), (0.0, 150.0, 0.0), 29.0)]  # the forearm
    parts += [_capsule((x, 30.0, 0.0), (1.15 * x, -42.0, 0.0), 15.0) for x in (-30, -10, 10, 30)]
    for x, length in ((-34.0, 72.0), (-12.0, 82.0), (11.0, 76.0), (34.0, 60.0)):
        parts += _finger((x, -42.0, 0.0), length, bend + rng.normal(0.0, 0.15), spread * x / 34.0)
    parts += _finger((-38.0, 20.0, -6.0), 62.0, 0.3 * bend, -0.9)
    return _joined(parts, size)


def _finger(
    root: tuple[float, float, float], length: float, bend: float, turn: float
) -> list[PointSet]:
    """Three links, each bent against the one before."""
    start, links = np.array(root), []
    for k, share in enumerate((0.45, 0.32, 0.23)):
        angle = bend * (k + 0.5) / 1.5
        along = np.array([np.sin(turn), -np.cos(turn) * np.cos(angle), -np.sin(angle)])
        stop = start + share * length * along
        links.append(_capsule(tuple(start), tuple(stop), 9.5 - 1.2 * k))
        start = stop
    return links


def _capsule(
    start: tuple[float, float, float], stop: tuple[float, float, float], radius: float
) -> PointSet:
    """A cylinder with half balls at its ends."""
    a, b = np.array(start), np.array(stop)
    axis = (b - a) / np.linalg.norm(b - a)
    side = np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    polar = np.linspace(0.0, np.pi, 16)[:, None, None]
    angle = np.linspace(0.0, 2.0 * np.pi, 20)[None, :, None]
    centre = np.where(polar < np.pi / 2.0, a, b)
    around = np.cos(angle) * side + np.sin(angle) * other
    return _grid(centre + radius * (np.sin(polar) * around - np.cos(polar) * axis))


def _grid(points: Float64) -> PointSet:
    """The surface of a grid of points (n, m, 3)."""
    rows, columns = points.shape[:2]
    first = np.arange(rows * columns).reshape(rows, columns)[:-1, :-1]
    corners = np.stack([first, first + 1, first + columns, first + columns + 1], axis=-1)
    triangles = corners[..., [[0, 1, 2], [1, 3, 2]]].reshape(-1, 3)
    return PointSet(points.reshape(-1, 3).astype(np.float32), triangles.astype(np.int32))


def _joined(parts: list[PointSet], scale: float) -> PointSet:
    firsts = np.cumsum([0] + [len(part.points) for part in parts[:-1]])
    triangles = [part.triangles + first for part, first in zip(parts, firsts, strict=True)]
    points = np.float32(scale) * np.concatenate([part.points for part in parts])
    return PointSet(points, np.concatenate(triangles))


def _waves(
    points: Float64, shortest_mm: float, longest_mm: float, rng: np.random.Generator
) -> Float64:
    """A random undulation of unit variance over (x, y), as in `_relief`."""
    length = shortest_mm * (longest_mm / shortest_mm) ** rng.random(24)
    direction, phase = 2.0 * np.pi * rng.random((2, 24))
    k = 2.0 * np.pi / length * np.stack([np.cos(direction), np.sin(direction)])
    return np.sqrt(2.0 / 24) * np.cos(points[..., :2] @ k + phase).sum(axis=-1)


def _soft(value: Float64, power: float) -> Float64:
    return np.sign(value) * np.abs(value) ** power


def _not_negative(name: str, value: float) -> None:
    if not value >= 0:
        raise ParameterError(f"{name}: must be ≥ 0, got {value}")
