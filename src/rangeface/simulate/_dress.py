"""What people wear on their faces: spectacles, beards, fringes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rangeface.simulate._anatomy import Anatomy, Field, Tissue, ramp

_RIM = 40  # vertices around a lens


def beard(anatomy: Anatomy, length_mm: float, rng: np.random.Generator) -> tuple[Field, Field]:
    """A full beard: how far it stands off the skin (n, 3), and where it grows (n,) 0 … 1."""
    a = anatomy
    cheek = ramp(a.level - 0.45 * np.abs(a.x), 2.0, 12.0) * ramp(-a.level, -108.0, -86.0)
    lips = np.hypot(a.x / 25.0, (a.level - 32.0) / 7.5)
    grows = a.front * cheek * ramp(lips, 0.9, 1.25) * ramp(a.level, 12.0, 19.0)
    rough = 1.0 + 0.15 * rng.standard_normal(a.x.shape)
    off = length_mm * grows * rough * (0.6 + 0.4 * ramp(a.level, 40.0, 70.0))
    return off[:, None] * _away(a), grows


def fringe(anatomy: Anatomy, low_mm: float, rng: np.random.Generator) -> tuple[Field, Field]:
    """Hair combed over the forehead down to the level `low_mm`; as for `beard`."""
    a = anatomy
    edge = low_mm + 3.0 * np.sin(a.x / 6.0 + 6.28 * rng.random()) + 0.12 * np.abs(a.x)
    covers = a.front * ramp(edge - a.level, 0.0, 3.0) * (1.0 - ramp(a.hairline, 0.0, 14.0))
    rough = 1.0 + 0.1 * rng.standard_normal(a.x.shape)
    return (6.0 * covers * rough)[:, None] * _away(a), covers


def _away(a: Anatomy) -> Field:
    return np.stack([np.sin(a.theta), 0.0 * a.theta, -np.cos(a.theta)], axis=-1)


def spectacles(
    eyes: tuple[Field, Field], nose_root: Field, side_x: float, rng: np.random.Generator
) -> tuple[Field, NDArray[np.int32], NDArray[np.int8]]:
    """Rims, bridge and arms as thin strips before the eyes.

    Clear lenses let infrared pass and are left out.

    Parameters
    ----------
    eyes : tuple of (3,) array
        Middle of the left and of the right eye, face frame, mm.
    nose_root : (3,) array
        Deepest point of the bridge, mm.
    side_x : float
        Half breadth of the head at the ears, mm.
    rng : numpy.random.Generator
        Source of the frame's form.

    Returns
    -------
    points : (m, 3) float64
    triangles : (k, 3) int32
    tissue : (m,) int8
    """
    half_x, half_y, width = rng.uniform(22, 27), rng.uniform(15, 21), rng.uniform(1.5, 5.0)
    boxy = rng.uniform(2.0, 4.5)
    z = nose_root[2] - rng.uniform(2.0, 5.0)
    strips = []
    for eye in eyes:
        angle = np.linspace(0.0, 2.0 * np.pi, _RIM)
        c, s = np.cos(angle), np.sin(angle)
        radius = (np.abs(c) ** boxy + np.abs(s) ** boxy) ** (-1.0 / boxy)
        wrap = 0.004 * (eye[0] + half_x * c * radius) ** 2
        rims = [
            np.stack([eye[0] + (half_x + w) * c * radius, eye[1] + (half_y + w) * s * radius + 2.0,
                      z + wrap], axis=-1)
            for w in (0.0, width)
        ]  # fmt: skip
        strips.append(rims)
        outer = np.sign(eye[0]) * np.array([np.abs(eye[0]) + half_x, side_x + 2.0])
        arm = np.stack([outer, [eye[1] - 4.0, eye[1] - 6.0], [z + wrap.max(), 95.0]], axis=-1)
        strips.append([arm, arm + np.array([0.0, width + 1.5, 0.0])])
    inner = max(0.5 * (eyes[0][0] - eyes[1][0]) - half_x, 4.0)
    bridge = np.array([[-inner, nose_root[1] + 2.0, z], [inner, nose_root[1] + 2.0, z]])
    strips.append([bridge, bridge + np.array([0.0, width, 0.0])])
    return _ribbons(strips)


def _ribbons(
    strips: list[list[Field]],
) -> tuple[Field, NDArray[np.int32], NDArray[np.int8]]:
    points, triangles, first = [], [], 0
    for upper, lower in strips:
        n = len(upper)
        i = first + np.arange(n - 1)
        points += [upper, lower]
        triangles += [np.stack([i, i + 1, i + n], -1), np.stack([i + 1, i + n + 1, i + n], -1)]
        first += 2 * n
    vertices = np.concatenate(points)
    return (
        vertices,
        np.concatenate(triangles).astype(np.int32),
        np.full(len(vertices), Tissue.FRAME, np.int8),
    )
