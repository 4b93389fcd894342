"""What makes one head another: shape factors, their deviations, and who tends to have them.

A factor is a smooth displacement of the mean head, one mm large where it is largest, times a
normally distributed weight. Deviations marked "F" follow Farkas (1994), those marked "Z" Zhuang
et al. (2010); a breadth's deviation is halved, for each side has its own half. The others are
assumed: chosen so that the spread of the whole surface agrees with published face models.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rangeface.simulate._anatomy import AXIS_Z_MM, Anatomy, Field, mean_anatomy, ramp

Shape: TypeAlias = Callable[[Anatomy], Field]


@dataclass(frozen=True)
class Factor:
    """One way in which heads differ.

    Parameters
    ----------
    name : str
        What it changes.
    deviation_mm : float
        Standard deviation between people of one sex and age, mm at the place of largest effect.
    shape : callable
        Anatomy → displacement (n, 3), 1 mm large.
    male : float
        Mean of men minus mean of all, in deviations; women have the opposite.
    decade : float
        Change per ten years from the age of 35, in deviations.
    stout : float
        Change per unit of stoutness (a standard normal variable), in deviations.
    source : str
        "F", "Z" or "assumed".
    """

    name: str
    deviation_mm: float
    shape: Shape
    male: float = 0.0
    decade: float = 0.0
    stout: float = 0.0
    source: str = "assumed"


# ── directions ───────────────────────────────────────────────────────────────────────────

_X, _Y, _Z = np.eye(3)


def forward(x: float, y: float, width: float, height: float, *, paired: bool = True) -> Shape:
    """A bump towards the camera at (±x, y)."""
    return lambda a: -a.bump(x, y, width, height, paired=paired)[:, None] * _Z


def outward(x: float, y: float, width: float, height: float) -> Shape:
    """A bump that moves both sides away from the midline."""
    return lambda a: (a.bump(x, y, width, height) * np.sign(a.x))[:, None] * _X


def down(x: float, y: float, width: float, height: float) -> Shape:
    """A bump that moves the surface down on both sides."""
    return lambda a: a.bump(x, y, width, height)[:, None] * _Y


def stretch(top: float, bottom: float) -> Shape:
    """Everything below `bottom` moves down (above `top` stays); reversed, everything above up."""
    sign = 1.0 if bottom > top else -1.0
    return lambda a: sign * ramp(sign * a.level, sign * top, sign * bottom)[:, None] * _Y


def widen(y: float, height: float) -> Shape:
    """The sides of the head move out around the level y."""
    return lambda a: (
        np.exp(-0.5 * ((a.level - y) / height) ** 2)
        * np.sign(a.x)
        * ramp(np.abs(a.x), 15.0, 68.0)
    )[:, None] * _X  # fmt: skip


def lean(start: float, end: float) -> Shape:
    """The face beyond the level `end` moves forward (before `start`, and the neck, stay)."""
    sign = 1.0 if end > start else -1.0
    return lambda a: -(
        a.front * ramp(sign * a.level, sign * start, sign * end) * ramp(-a.level, -102, -80)
    )[:, None] * _Z  # fmt: skip


def sink(y: float, height: float) -> Shape:
    """The sides of the head move down around the level y."""
    return lambda a: (
        np.exp(-0.5 * ((a.level - y) / height) ** 2) * ramp(np.abs(a.x), 15.0, 60.0)
    )[:, None] * _Y  # fmt: skip


def _size(a: Anatomy) -> Field:
    return (a.points - [0.0, 0.0, AXIS_Z_MM]) / 100.0


def _length(a: Anatomy) -> Field:
    return ramp(a.points[:, 2], 15.0, 190.0)[:, None] * _Z


def _flatness(a: Anatomy) -> Field:
    return -(a.front * np.clip(np.abs(a.x) / 50.0, 0, 1.3) ** 2)[:, None] * _Z


def _ears(a: Anatomy, direction: NDArray[np.float64]) -> Field:
    shell = np.exp(
        -0.5 * (((np.degrees(np.abs(a.theta)) - 106) / 8.5) ** 2 + ((a.level + 14) / 20) ** 2)
    )
    sides = np.where(direction[0] != 0, np.sign(a.x), 1.0)
    return (shell * sides)[:, None] * direction


def _below_chin(a: Anatomy) -> Field:
    away = np.degrees(np.abs(a.theta))
    soft = np.exp(-0.5 * (((a.level - 90) / 9) ** 2 + (away / 45) ** 2))
    return -soft[:, None] * _Z + 0.4 * soft[:, None] * _Y


def _neck(a: Anatomy) -> Field:
    girth = np.exp(-0.5 * ((a.level - 108) / 22) ** 2) * ramp(a.level, 62, 92)
    return girth[:, None] * (np.sin(a.theta)[:, None] * _X - np.cos(a.theta)[:, None] * _Z)


def _shoulders(a: Anatomy) -> Field:
    return ramp(a.level, 118, 160)[:, None] * _Y


def hair_volume(a: Anatomy) -> Field:
    """Hair grows thicker: away from the skull, most on top."""
    volume = ramp(a.hairline, 0.0, 22.0) * (0.55 + 0.45 * ramp(-a.level, 40, 110))
    rise = ramp(-a.level, 70, 150)
    side = np.sqrt(1.0 - 0.8 * rise)
    direction = np.stack([np.sin(a.theta) * side, -rise, -np.cos(a.theta) * side], axis=-1)
    return volume[:, None] * direction


def _canthal_tilt(a: Anatomy) -> Field:
    return (a.bump(31, -37, 12, 7) * (np.abs(a.x) - 31) / 12)[:, None] * -_Y


# ── the table ────────────────────────────────────────────────────────────────────────────

FACTORS: tuple[Factor, ...] = (
    Factor("size", 2.2, _size, male=0.75, source="Z"),
    Factor("head length", 5.0, _length, male=0.3, source="Z"),
    Factor("head breadth", 2.2, widen(-80, 45), male=0.1, source="Z"),
    Factor("frontal breadth", 2.3, widen(-68, 18), male=-0.1, source="Z"),
    Factor("zygomatic breadth", 2.6, widen(-12, 22), male=0.3, stout=0.3, source="Z"),
    Factor("gonial breadth", 3.0, widen(46, 20), male=0.5, stout=0.6, source="Z"),
    Factor("forehead height", 3.8, stretch(-60, -105), male=0.1, source="F"),
    Factor("nose length", 2.6, stretch(-4, -42), male=0.2, decade=0.1, source="F"),
    Factor("upper lip height", 1.7, stretch(10, 30), male=0.3, decade=0.12, source="F"),
    Factor("chin height", 2.6, stretch(33, 76), male=0.5, source="F"),
    Factor("gonion level", 3.0, sink(48, 16)),
    Factor("nose protrusion", 2.3, forward(0, 0, 8.5, 12), male=0.3, decade=0.08, source="F"),
    Factor("bridge height", 1.8, forward(0, -22, 7.5, 12), male=0.4),
    Factor("sellion depth", 1.7, forward(0, -41, 9, 7), male=0.1),
    Factor("nasal hump", 1.0, forward(0, -20, 5, 6), male=0.4),
    Factor("nose width", 2.0, outward(14, 3, 6, 8), male=0.5, decade=0.08, source="F"),
    Factor("tip rotation", 1.8, down(0, 0, 9, 8), male=0.2, decade=0.12),
    Factor("tip breadth", 0.9, forward(5.5, -1, 3.5, 5)),
    Factor("nasal root breadth", 1.0, forward(9, -36, 4.5, 7), male=0.2, source="Z"),
    Factor("bridge breadth", 1.0, forward(9, -18, 4.5, 9)),
    Factor("alar height", 1.3, forward(13, 2, 4.5, 5)),
    Factor("columella", 1.2, down(0, 8, 6, 4)),
    Factor("brow ridge", 1.5, forward(26, -57, 15, 6), male=0.7, decade=0.05),
    Factor("glabella", 1.2, forward(0, -57, 13, 8), male=0.5),
    Factor("forehead slope", 3.0, lean(-60, -118), male=-0.5),
    Factor("frontal bosses", 1.5, forward(27, -88, 15, 13), male=-0.3),
    Factor("temples", 1.8, forward(56, -60, 11, 16), stout=0.3),
    Factor("eye depth", 2.0, forward(30, -39, 14, 8), male=-0.4, decade=-0.08),
    Factor("eye bulge", 0.9, forward(31.5, -37, 9, 6)),
    Factor("eye distance", 1.5, outward(31, -38, 13, 9), male=0.2, source="F"),
    Factor("eye level", 1.3, down(31, -38, 14, 8)),
    Factor("canthal tilt", 1.0, _canthal_tilt, male=-0.2, decade=-0.08),
    Factor("lid fold", 0.7, forward(31, -44, 13, 3), decade=0.12),
    Factor("eye bags", 0.7, forward(29, -26, 11, 4), decade=0.25),
    Factor("brow level", 1.6, down(27, -56, 16, 6), male=0.4, decade=0.1),
    Factor("cheekbones", 1.9, forward(45, -16, 13, 11), male=-0.1),
    Factor("cheekbone level", 2.0, down(45, -12, 13, 12)),
    Factor("cheek fullness", 3.3, forward(43, 22, 14, 16), stout=0.8, decade=-0.08),
    Factor("midface", 2.2, forward(27, -12, 10, 10)),
    Factor("lateral cheek", 2.8, forward(60, 8, 10, 22), stout=0.4),
    Factor("maxilla", 3.4, forward(0, 25, 19, 13)),
    Factor("mandible", 2.2, lean(22, 62), male=0.1),
    Factor("chin prominence", 2.0, forward(0, 62, 13, 10), male=0.3),
    Factor("chin breadth", 1.5, forward(15, 65, 8, 9), male=0.5),
    Factor("chin level", 1.5, down(0, 66, 13, 9)),
    Factor("mentolabial sulcus", 1.4, forward(0, 48, 15, 5)),
    Factor("jowls", 1.8, forward(33, 60, 11, 11), stout=0.4, decade=0.2),
    Factor("mouth width", 1.7, outward(23, 32, 8, 8), male=0.3, decade=0.08, source="Z"),
    Factor("upper lip", 1.3, forward(0, 27, 17, 4), male=-0.2, decade=-0.15),
    Factor("lower lip", 1.5, forward(0, 38, 16, 5), decade=-0.1),
    Factor("lip height", 1.4, lambda a: down(0, 40, 17, 5)(a) - down(0, 25, 17, 5)(a), male=-0.2),
    Factor("nasolabial fold", 1.1, forward(27, 18, 5, 10), stout=0.2, decade=0.25),
    Factor("philtrum", 0.6, forward(0, 19, 3.5, 6)),
    Factor("flatness", 2.8, _flatness),
    Factor("ear protrusion", 2.8, lambda a: _ears(a, _X), decade=0.05),
    Factor("ear level", 2.5, lambda a: _ears(a, _Y)),
    Factor("ear depth", 3.0, lambda a: _ears(a, _Z)),
    Factor("below the chin", 2.6, _below_chin, stout=0.8, decade=0.15),
    Factor("neck girth", 3.4, _neck, male=0.9, stout=0.7, source="Z"),
    Factor("shoulder level", 9.0, _shoulders),
    Factor("hair volume", 5.0, hair_volume, male=-0.5),
)  # fmt: skip


def _one_sided(shape: Shape) -> Shape:
    return lambda a: 0.5 * np.tanh(a.x / 6.0)[:, None] * shape(a)


def _sideways(x: float, y: float, width: float, height: float) -> Shape:
    return lambda a: a.bump(x, y, width, height)[:, None] * _X


# left minus right; Farkas reports differences of 1 to 3 mm in most adults
ASYMMETRY: tuple[Factor, ...] = (
    Factor("nose deviation", 0.8, _sideways(0, 2, 9, 12)),
    Factor("bridge deviation", 0.6, _sideways(0, -22, 8, 12)),
    Factor("chin deviation", 1.2, lambda a: (a.front * ramp(a.level, 20, 70))[:, None] * _X),
    Factor("eye level difference", 1.2, _one_sided(down(31, -40, 14, 12))),
    Factor("brow difference", 1.2, _one_sided(forward(27, -57, 15, 7))),
    Factor("cheek difference", 2.0, _one_sided(forward(43, 10, 17, 22)), source="F"),
    Factor("mouth tilt", 1.2, _one_sided(down(20, 33, 12, 8))),
    Factor("jaw difference", 2.0, _one_sided(widen(48, 20)), source="F"),
    Factor("nostril difference", 0.8, _one_sided(forward(12, 4, 5, 5))),
)  # fmt: skip


@lru_cache(maxsize=1)
def basis() -> NDArray[np.float32]:
    """Displacement of every factor, then of every asymmetry: (k, n, 3), one deviation each."""
    a = mean_anatomy()
    return np.stack(
        [(f.deviation_mm * f.shape(a)).astype(np.float32) for f in (*FACTORS, *ASYMMETRY)]
    )


def tendencies() -> tuple[Field, Field, Field]:
    """Shift of each weight: for a man, per decade of age, per unit of stoutness."""
    every = (*FACTORS, *ASYMMETRY)
    male, decade, stout = (
        np.array([getattr(f, name) for f in every]) for name in ("male", "decade", "stout")
    )
    return male, decade, stout
