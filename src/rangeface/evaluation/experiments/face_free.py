"""Scenes without a face: what a finder must refuse."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from rangeface import simulate
from rangeface.numerics.se3 import rotation_matrix
from rangeface.types import Pinhole, PointSet, RigidTransform

Placed: TypeAlias = tuple[simulate.Head | PointSet, RigidTransform]


def scene(kind: str, seed: int, camera: Pinhole) -> simulate.Scene:
    """A face-free view of one of the `KINDS`; the same numbers give the same view."""
    rng = np.random.default_rng([seed, *kind.encode()])
    things = KINDS[kind](rng)
    if kind != "wall" and rng.random() < 0.5:
        things.append((simulate.wall(rng.uniform(900.0, 1600.0)), _still()))
    surfaces, poses = zip(*things, strict=True)
    return simulate.render(list(surfaces), camera, list(poses))


def _still() -> RigidTransform:
    return RigidTransform(np.eye(3), np.zeros(3), target="camera", source="face")


def _anywhere(
    rng: np.random.Generator, *, turn: float, nearest: float = 380.0, furthest: float = 750.0
) -> RigidTransform:
    """A random place in view, turned about a random axis by up to `turn` (rad)."""
    z = rng.uniform(nearest, furthest)
    x, y = rng.uniform(-0.15, 0.15, 2) * z
    axis = rng.normal(size=3)
    R = rotation_matrix(rng.uniform(0.0, turn) * axis / np.linalg.norm(axis))
    return RigidTransform(R, np.array([x, y, z]), target="camera", source="face")


def _wall(rng: np.random.Generator) -> list[Placed]:
    z = rng.uniform(500.0, 900.0)
    tilt = rotation_matrix([*rng.uniform(-0.7, 0.7, 2), 0.0])
    place = RigidTransform(tilt, np.array([0.0, 0.0, z]), target="camera", source="face")
    shift = RigidTransform(np.eye(3), np.array([0.0, 0.0, -1.0]), target="face", source="face")
    return [(simulate.wall(1.0, half_mm=400.0), place @ shift)]


def _ball(rng: np.random.Generator) -> list[Placed]:
    return [
        (simulate.ball(rng.uniform(30.0, 160.0)), _anywhere(rng, turn=0.0, nearest=450.0))
        for _ in range(rng.integers(1, 4))
    ]


def _hand(rng: np.random.Generator) -> list[Placed]:
    return [(simulate.hand(rng=rng), _anywhere(rng, turn=1.0)) for _ in range(rng.integers(1, 3))]


def _cushion(rng: np.random.Generator) -> list[Placed]:
    wrinkles = rng.uniform(0.0, 5.0)
    return [(simulate.cushion(wrinkles_mm=wrinkles, rng=rng), _anywhere(rng, turn=0.8))]


def _shoulders(rng: np.random.Generator) -> list[Placed]:
    folds = rng.uniform(0.0, 5.0)
    return [(simulate.shoulders(folds_mm=folds, rng=rng), _anywhere(rng, turn=0.4))]


def _back_of_head(rng: np.random.Generator) -> list[Placed]:
    yaw = 180.0 + rng.uniform(-60.0, 60.0)
    x, y, z = *rng.uniform(-40.0, 40.0, 2), rng.uniform(450.0, 800.0)
    pose = simulate.pose(
        yaw_deg=yaw, pitch_deg=rng.uniform(-20.0, 20.0), roll_deg=rng.uniform(-15.0, 15.0),
        nose_tip_mm=(float(x), float(y), float(z + 200.0)),
    )  # fmt: skip
    return [(simulate.head(int(rng.integers(1, 1_000_000))), pose)]


#: kind → what stands in the view.
KINDS: Mapping[str, Callable[[np.random.Generator], list[Placed]]] = MappingProxyType(
    {
        "wall": _wall,
        "ball": _ball,
        "hand": _hand,
        "cushion": _cushion,
        "shoulders": _shoulders,
        "back of a head": _back_of_head,
    }
)
