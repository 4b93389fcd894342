"""The mean adult head as a closed-form surface: what every simulated person deviates from.

Around a vertical axis near the ears the skull is a stack of super-ellipses; the jaw steps back
to the neck along the border of the mandible; nose, eyes, lips, cheekbones and chin are smooth
bumps along the line of sight. The sizes are means over women and men from published surveys
(see `docs/theory/simulate.md`): Farkas, *Anthropometry of the Head and Face*, 2nd ed., Raven,
1994; Zhuang et al., Ann. Occup. Hyg. 54(4), 2010, doi:10.1093/annhyg/meq007. Everything is in
the face frame: nose tip at the origin, x to the subject's left, y down, z into the head, mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

Field: TypeAlias = NDArray[np.float64]

AXIS_Z_MM = 108.0  # depth of the vertical axis of the skull behind the nose tip
VERTEX_Y_MM = -154.0  # top of the head
BROW_Y_MM = -60.0  # where the vault of the skull begins
COLUMNS = 135


class Tissue(IntEnum):
    """What a vertex is made of; its near-infrared reflectivity follows from it."""

    SKIN = 0
    HAIR = 1
    EYE = 2
    CLOTH = 3
    FRAME = 4


@dataclass(frozen=True, eq=False)
class Anatomy:
    """The grid of the mean head and where each vertex lies on it.

    `theta` (rad, 0 = forward) and `level` (mm) are the cylinder coordinates of the grid;
    `x`, `y` are mm in the frontal view; `front` fades from 1 on the face to 0 at the ears.
    """

    theta: Field
    level: Field
    x: Field
    y: Field
    front: Field
    points: Field
    triangles: NDArray[np.int32]
    tissue: NDArray[np.int8]
    hairline: Field  # mm above the hairline, negative below it

    def bump(
        self, x: float, y: float, width: float, height: float, *, paired: bool = True
    ) -> Field:
        """A Gaussian of unit peak on the face at (±x, y), with the given half-widths, mm."""
        across = np.abs(self.x) - x if paired else self.x - x
        return self.front * np.exp(-0.5 * ((across / width) ** 2 + ((self.y - y) / height) ** 2))


def ramp(value: ArrayLike, low: float, high: float) -> Field:
    """Smooth step from 0 at `low` to 1 at `high` (cubic, flat at both ends)."""
    t = np.clip((np.asarray(value, np.float64) - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def curve(value: ArrayLike, *knots: tuple[float, float]) -> Field:
    """Monotone piecewise cubic through the knots (position, value), constant outside them."""
    at, to = np.array(knots).T
    return np.asarray(PchipInterpolator(at, to)(np.clip(value, at[0], at[-1])))


def spline(value: ArrayLike, *knots: tuple[float, float]) -> Field:
    """Smooth cubic through the knots (position, value), flat at both ends, constant outside."""
    at, to = np.array(knots).T
    return np.asarray(CubicSpline(at, to, bc_type="clamped")(np.clip(value, at[0], at[-1])))


@lru_cache(maxsize=1)
def mean_anatomy() -> Anatomy:
    """The mean head, computed once."""
    angle, height = _columns(), _rows()
    theta, level = (a.ravel() for a in np.meshgrid(angle, height))
    vault = _vault(level)
    radius = _skull(theta, level, vault)
    x, z = radius * np.sin(theta), AXIS_Z_MM - radius * np.cos(theta)
    front = 1.0 - ramp(np.abs(theta), np.radians(58), np.radians(84))
    above = _hairline(theta) - level
    relief = front * (_nose(x, level) + _eyes(x, level) + _mouth(x, level) + _cheeks(x, level))
    outward = _ear(theta, level) + 7.0 * ramp(above, -2.0, 22.0)
    sideways, upwards = outward * vault, outward * np.sqrt(1.0 - vault**2)
    points = np.stack(
        [x + sideways * np.sin(theta), level - upwards, z - relief - sideways * np.cos(theta)],
        axis=-1,
    )
    return Anatomy(
        theta, level, x, level, front, points, _triangles(height.size),
        _tissue(theta, level, x, above), above,
    )  # fmt: skip


def _columns() -> Field:
    # dense where the face is, denser than the skull at the ears, sparse at the back
    fine = np.linspace(0.0, np.pi, 4001)
    density = (
        1.0 / 1.35
        - (1 / 1.35 - 1 / 2.6) * ramp(fine, np.radians(30), np.radians(62))
        - (1 / 2.6 - 1 / 11.0) * ramp(fine, np.radians(112), np.radians(135))
    )
    share = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    half = np.interp(np.arange(1, COLUMNS // 2 + 1), share / share[-1] * (COLUMNS / 2), fine)
    return np.concatenate([-half[::-1], [0.0], half])


def _rows() -> Field:
    vault = BROW_Y_MM - (BROW_Y_MM - VERTEX_Y_MM) * np.sin(np.radians(np.linspace(90, 34, 11)))
    bands = (
        (-105, 13),
        (-55, 20),
        (-5, 19),
        (28, 10),
        (37, 4),
        (44, 14),
        (84, 8),
        (120, 6),
        (190, 3),
        (300, 1),
    )
    below = [
        np.linspace(start, stop, count, endpoint=False)
        for (start, count), (stop, _) in pairwise(bands)
    ]
    return np.concatenate([vault[vault < -107], *below, [300.0]])


def _triangles(rows: int) -> NDArray[np.int32]:
    first = np.arange((rows - 1) * COLUMNS).reshape(rows - 1, COLUMNS)
    right = np.roll(first, -1, axis=1)
    upper = np.stack([first, first + COLUMNS, right], axis=-1)
    lower = np.stack([right, first + COLUMNS, right + COLUMNS], axis=-1)
    return np.concatenate([upper.reshape(-1, 3), lower.reshape(-1, 3)]).astype(np.int32)


# ── the skull, the jaw, the neck ─────────────────────────────────────────────────────────


def _superellipse(theta: Field, side: Field, depth: Field, power: Field) -> Field:
    return ((np.abs(np.sin(theta)) / side) ** power + (np.abs(np.cos(theta)) / depth) ** power) ** (
        -1.0 / power
    )


def _vault(level: Field) -> Field:
    # radius of the skull over its radius at the brow
    rise = np.clip((BROW_Y_MM - level) / (BROW_Y_MM - VERTEX_Y_MM), 0.0, 1.0)
    return (1.0 - rise**1.8) ** 0.46


def _skull(theta: Field, level: Field, vault: Field) -> Field:
    forward = np.cos(theta) > 0
    # midline of the face without nose and lips: depth behind the nose tip
    midline = spline(
        level, (-62, 23.5), (-41, 27.0), (-22, 31.0), (-2, 28.0), (16, 22.5), (34, 22.0),
        (50, 22.0), (66, 23.0), (80, 25), (94, 31),
    )  # fmt: skip
    side = spline(level, (-62, 75.5), (-35, 73.5), (0, 72), (25, 69), (50, 65), (70, 58), (88, 49))
    back = curve(level, (-70, 92), (-20, 90), (30, 76), (80, 62))
    power = spline(level, (-110, 2.1), (-60, 2.2), (-15, 2.35), (30, 2.15), (60, 2.1), (85, 2.1))
    head = vault * _superellipse(theta, side, np.where(forward, AXIS_Z_MM - midline, back), power)
    return head + (_neck(theta, level) - head) * _below_jaw(theta, level)


def _below_jaw(theta: Field, level: Field) -> Field:
    # border of the mandible: gnathion, gonion, ear lobe, then the nape
    away = np.degrees(np.abs(theta))
    border = curve(
        away,
        (0, 86),
        (14, 85),
        (32, 78),
        (50, 64),
        (62, 50),
        (76, 33),
        (92, 22),
        (130, 25),
        (180, 30),
    )  # fmt: skip
    softness = curve(away, (0, 8.5), (40, 8.5), (62, 12), (95, 20), (130, 32), (180, 36))
    return ramp((level - border) / softness, -1.0, 1.0)


def _neck(theta: Field, level: Field) -> Field:
    side = curve(
        level, (60, 55), (110, 57), (128, 68), (150, 112), (185, 172), (230, 205), (300, 215)
    )
    chest = curve(level, (60, 36), (95, 36), (115, 38), (150, 55), (200, 76), (300, 92))
    nape = curve(level, (0, 66), (60, 60), (110, 62), (150, 84), (200, 98), (300, 100))
    depth = np.where(np.cos(theta) > 0, chest, nape)
    return _superellipse(theta, side, depth, curve(level, (60, 2.0), (120, 2.0), (200, 2.4)))


# ── the features: mm towards the camera ──────────────────────────────────────────────────


def _gauss(x: Field, y: Field, x0: float, y0: float, width: float, height: float) -> Field:
    return np.exp(-0.5 * (((np.abs(x) - x0) / width) ** 2 + ((y - y0) / height) ** 2))


def _nose(x: Field, y: Field) -> Field:
    # height of the ridge above the midline: sellion, bridge, tip, columella. The alar crease
    # lies 28 mm behind the tip: ala length (ac–prn) 33.5 mm, half the alar width 17.5 mm
    ridge = spline(
        y + 0.2 * np.abs(x) * ramp(y, -12.0, 4.0),  # the base rises towards the wings
        (-58, 0), (-46, 3.0), (-41, 5.2), (-32, 10.6), (-22, 17.4), (-12, 23.6), (-5, 27.0),
        (-1, 27.8), (3, 26.6), (6, 23.6), (9, 17.0), (12, 9.0), (15, 3.0), (18, 0.6), (22, 0),
    )  # fmt: skip
    half = curve(y, (-45, 8.0), (-30, 8.8), (-16, 11.0), (-8, 12.0), (0, 12.6), (8, 11.5), (14, 9))
    blunt = curve(y, (-40, 1.9), (-24, 2.0), (-12, 2.5), (-2, 3.0), (12, 2.6))
    bridge = ridge * np.exp(-((np.abs(x) / half) ** blunt))
    wings = 9.0 * _gauss(x, y, 13.0, 3.5, 3.6, 5.0)
    nostrils = 3.6 * _gauss(x, y, 6.4, 10.4, 3.0, 2.0) + 1.4 * _gauss(x, y, 20.5, 6.0, 2.6, 6.0)
    return bridge + wings - nostrils


def _eyes(x: Field, y: Field) -> Field:
    brow = 2.3 * _gauss(x, y + 0.1 * (np.abs(x) - 28), 26.0, -57.0, 15.0, 5.0)
    glabella = 1.8 * _gauss(x, y, 0.0, -57.0, 13.0, 7.0)
    socket = 5.2 * _gauss(x, y, 30.0, -39.0, 13.0, 7.0) + 7.4 * _gauss(x, y, 16.8, -37.5, 5.2, 6.0)
    ball = 7.0 * _gauss(x, y, 31.5, -36.4, 8.8, 5.6)
    almond = np.clip(1.0 - ((np.abs(x) - 31.5) / 15.5) ** 2, 0.0, 1.0)
    slit = 1.5 * almond**0.3 * np.exp(-0.5 * ((np.abs(y + 37.0) - 5.6 * almond) / 1.4) ** 2)
    bag = 1.0 * _gauss(x, y, 30.0, -25.0, 12.0, 3.0)
    return brow + glabella + ball - socket - slit - bag


def _mouth(x: Field, y: Field) -> Field:
    across = np.clip(1.0 - (x / 26.0) ** 2, 0.0, 1.0)
    seam = 31.6 + 0.8 * np.exp(-((x / 5) ** 2)) + 0.0009 * x**2
    upper = 4.2 * across**0.8 * np.exp(-0.5 * ((y - seam + 4.6) / 2.9) ** 2)
    lower = 5.0 * across**0.9 * np.exp(-0.5 * ((y - seam - 5.6) / 3.3) ** 2)
    line = 2.2 * across**0.5 * np.exp(-0.5 * ((y - seam) / 1.3) ** 2)
    corner = 1.8 * _gauss(x, y, 26.0, 33.0, 3.4, 3.6)
    philtrum = 0.9 * _gauss(x, y, 0.0, 19.5, 2.6, 4.5) - 0.5 * _gauss(x, y, 5.2, 20.0, 2.2, 5.0)
    arch = 7.0 * _gauss(x, y, 0.0, 31.0, 16.0, 14.0)  # the teeth behind the lips
    return upper + lower + arch - line - corner - philtrum


def _cheeks(x: Field, y: Field) -> Field:
    bone = 3.6 * _gauss(x, y, 47.0, -16.0, 13.0, 10.0)
    apple = 2.0 * _gauss(x, y, 34.0, 0.0, 12.0, 13.0)
    hollow = 1.6 * _gauss(x, y, 46.0, 30.0, 12.0, 14.0)
    fold = 1.5 * _gauss(np.abs(x) - 0.45 * (y - 8), y, 21.5, 18.0, 3.0, 12.0)
    chin = 4.2 * _gauss(x, y, 0.0, 63.0, 13.5, 8.5) + 1.2 * _gauss(x, y, 9.0, 66.0, 7.0, 6.0)
    temple = 1.0 * _gauss(x, y, 59.0, -62.0, 10.0, 16.0)
    return bone + apple + chin - hollow - fold - temple


def _ear(theta: Field, level: Field) -> Field:
    # a shell that leans back and outwards: tragus in front, helix at its rim
    away = np.degrees(np.abs(theta)) + 0.12 * (level + 14.0)
    across, along = (away - 103.0) / 16.0, (level + 14.0) / 33.0
    lobe = 1.0 + 0.25 * along
    inside = 1.0 - ramp(np.hypot(across * lobe, along), 0.8, 1.02)
    shell = 5.0 + 14.0 * ramp(across, -1.0, 0.8)
    concha = 8.0 * np.exp(-0.5 * (((across + 0.25) / 0.42) ** 2 + ((along - 0.2) / 0.38) ** 2))
    return inside * (shell - concha)


# ── what it is made of ───────────────────────────────────────────────────────────────────


def _hairline(theta: Field) -> Field:
    away = np.degrees(np.abs(theta))
    return curve(
        away, (0, -104), (25, -101), (42, -88), (54, -66), (66, -50), (80, -26), (86, -30),
        (96, -52), (112, -46), (122, 0), (140, 40), (180, 52),
    )  # fmt: skip


def _tissue(theta: Field, level: Field, x: Field, above: Field) -> NDArray[np.int8]:
    tissue = np.full(theta.shape, int(Tissue.SKIN), np.int8)
    eye = ((np.abs(x) - 31.5) / 14.5) ** 2 + ((level + 37.0) / 4.8) ** 2 < 1.0
    tissue[eye & (np.cos(theta) > 0)] = Tissue.EYE
    brow = (np.abs(level + 58.0 + 0.1 * (np.abs(x) - 28)) < 3.4) & (np.abs(np.abs(x) - 30) < 17)
    tissue[brow & (np.cos(theta) > 0.5)] = Tissue.HAIR
    tissue[(above > 0) & (_ear(theta, level) < 1.0)] = Tissue.HAIR
    collar = curve(np.degrees(np.abs(theta)), (0, 138), (60, 122), (120, 112), (180, 105))
    tissue[level > collar] = Tissue.CLOTH
    return tissue
