"""Expressions: each is a blend of a few muscle actions, each person's blend a little different."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError
from rangeface.simulate._anatomy import Anatomy, Field, mean_anatomy, ramp
from rangeface.simulate._identity import Shape, down, forward, outward

_TEMPOROMANDIBULAR = (-12.0, 88.0)  # y, z of the joint that the jaw turns about, mm


def _total(*parts: tuple[float, Shape]) -> Shape:
    return lambda a: np.sum([amount * shape(a) for amount, shape in parts], axis=0)


def _jaw_mask(a: Anatomy) -> Field:
    # sharp between the lips, soft in the cheeks, nothing on the neck
    side = ramp(np.abs(a.x), 20.0, 48.0)
    soft = np.clip((a.level - (31.0 - 26.0 * side)) / (3.6 + 46.0 * side), 0.0, 1.0)
    return soft * a.front * (1.0 - ramp(a.points[:, 2], 46.0, 72.0))


def _jaw_drop(a: Anatomy) -> Field:
    """The mandible turns by one degree; between the lips the mouth's hollow opens."""
    mask = _jaw_mask(a)
    arm_y, arm_z = a.level - _TEMPOROMANDIBULAR[0], _TEMPOROMANDIBULAR[1] - a.points[:, 2]
    turn = np.radians(1.0) * mask
    hollow = 2.2 * 4.0 * mask * (1.0 - mask) * np.clip(1.0 - (a.x / 25.0) ** 2, 0.0, 1.0)
    return np.stack([np.zeros_like(mask), turn * arm_z, 0.75 * turn * arm_y + hollow], axis=-1)


def _jaw_side(a: Anatomy) -> Field:
    return np.stack([_jaw_mask(a), 0.0 * a.x, 0.0 * a.x], axis=-1)


def _left_only(shape: Shape) -> Shape:
    return lambda a: ramp(a.x, -6.0, 14.0)[:, None] * shape(a)


# each action is about one millimetre large (the jaw: one degree)
ACTIONS: Mapping[str, Shape] = MappingProxyType(
    {
        "corners up": down(27, 31, 9, 7),
        "corners out": outward(25, 32, 11, 8),
        "corners back": forward(27, 32, 8, 8),
        "one corner": _left_only(_total((-0.7, down(27, 31, 9, 7)), (0.7, outward(25, 32, 11, 8)))),
        "lips part": _total((0.5, down(0, 38, 20, 5)), (-0.5, down(0, 26, 20, 5))),
        "lips thin": _total((-1.0, forward(0, 27, 20, 4)), (-1.0, forward(0, 38, 18, 4))),
        "pucker": _total((-0.8, outward(22, 32, 11, 9)), (0.9, forward(0, 32, 11, 9))),
        "cheeks raise": _total((0.6, forward(36, -4, 12, 9)), (-0.8, down(36, 4, 12, 12))),
        "cheeks puff": forward(38, 28, 13, 14),
        "fold": _total((-0.5, forward(31, 20, 3.5, 11)), (0.3, forward(38, 14, 6, 11))),
        "brows raise": _total((-1.0, down(27, -58, 18, 9)), (0.15, forward(24, -78, 25, 5))),
        "brows lower": _total((0.8, down(16, -55, 12, 7)), (-0.5, outward(14, -56, 10, 6))),
        "brows knit": _total((0.8, forward(8, -56, 7, 6)), (-0.5, forward(0, -58, 3, 8))),
        "eyes narrow": _total((-0.5, forward(31, -37, 10, 4)), (0.5, forward(31, -28, 11, 4))),
        "nose wrinkle": _total((0.5, forward(9, -28, 6, 8)), (-0.8, down(13, 4, 8, 10))),
        "nose widens": _total((1.0, outward(14, 3, 6, 7)), (-0.5, forward(0, 0, 9, 8))),
        "jaw": _jaw_drop,
        "jaw aside": _jaw_side,
    }
)

EXPRESSIONS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "neutral": {},
        "smile": {
            "corners up": -4.0, "corners out": 5.0, "corners back": -2.5, "lips thin": 0.8,
            "cheeks raise": 4.0, "fold": 3.0, "eyes narrow": 1.2, "nose widens": 1.5,
        },
        "laugh": {
            "corners up": -5.5, "corners out": 8.0, "corners back": -8.0, "lips thin": 1.5,
            "cheeks raise": 8.0, "fold": 5.0, "eyes narrow": 2.5, "lips part": 3.0,
            "nose wrinkle": 1.0, "nose widens": 2.5, "jaw": 14.0,
        },
        "frown": {
            "brows lower": 4.0, "brows knit": 2.2, "eyes narrow": 1.5, "corners up": 2.5,
            "lips thin": 0.8, "nose wrinkle": 1.0, "fold": 0.8,
        },
        "surprise": {
            "brows raise": 7.0, "eyes narrow": -1.2, "jaw": 13.0, "pucker": 3.0,
            "cheeks raise": -1.0,
        },
    }
)  # fmt: skip

# standard deviations of the actions in a random gesture
_RANDOM: Mapping[str, float] = MappingProxyType(
    {
        "corners up": 2.5, "corners out": 3.0, "one corner": 5.0, "lips thin": 1.0, "pucker": 4.0,
        "cheeks raise": 2.0, "cheeks puff": 4.0, "fold": 1.5, "brows raise": 3.5,
        "brows lower": 2.0, "brows knit": 1.2, "eyes narrow": 1.2, "nose wrinkle": 1.5,
        "jaw aside": 4.0,
    }
)  # fmt: skip


@lru_cache(maxsize=1)
def _action_basis() -> NDArray[np.float32]:
    a = mean_anatomy()
    return np.stack([shape(a).astype(np.float32) for shape in ACTIONS.values()])


def gesture(expression: str, strength: float, *, person: int, rng: np.random.Generator) -> Field:
    """Displacement of the mean head's vertices by an expression.

    Parameters
    ----------
    expression : str
        One of `EXPRESSIONS`, or "random".
    strength : float
        0 = neutral, 1 = full, up to 1.5.
    person : int
        Number of the person, who always smiles the same way.
    rng : numpy.random.Generator
        Source of what a "random" gesture is.

    Returns
    -------
    (n, 3) float64
        mm.

    Raises
    ------
    ParameterError
        An unknown expression, or a strength out of range.
    """
    if expression != "random" and expression not in EXPRESSIONS:
        known = ", ".join([*EXPRESSIONS, "random"])
        raise ParameterError(f"expression: unknown {expression!r}; known: {known}")
    if not 0.0 <= strength <= 1.5:
        raise ParameterError(f"strength: must lie in 0 … 1.5, got {strength}")
    if expression == "random":
        blend = {name: float(rng.normal(0.0, size)) for name, size in _RANDOM.items()}
        blend["jaw"] = float(np.maximum(rng.normal(1.0, 5.0), 0.0))
    else:
        blend = dict(EXPRESSIONS[expression])
    manner = np.random.default_rng([person, 0x5141]).normal(1.0, 0.25, len(ACTIONS))
    weights = np.array([blend.get(name, 0.0) for name in ACTIONS]) * np.clip(manner, 0.4, 1.6)
    weights = (strength * weights).astype(np.float32)
    return np.einsum("k,k...", weights, _action_basis()).astype(np.float64)
