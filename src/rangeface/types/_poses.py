"""Rigid motions between named frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rangeface.errors import ParameterError
from rangeface.numerics import se3
from rangeface.types._arrays import Float64, frozen


@dataclass(frozen=True, eq=False)
class RigidTransform:
    """A proper rigid motion from frame `source` to frame `target`: q = R p + t.

    Parameters
    ----------
    rotation : (3, 3) array_like
        Orthonormal, det = +1: a reflection cannot be built.
    translation : (3,) array_like
        mm.
    target, source : str
        Names of the frames; composition checks them.

    Raises
    ------
    ParameterError
        The rotation is not proper, or a value is not finite.
    """

    rotation: Float64
    translation: Float64
    target: str = "face"
    source: str = "camera"

    def __post_init__(self) -> None:
        R = frozen(self.rotation, np.float64, "rotation", (3, 3))
        t = frozen(self.translation, np.float64, "translation", (3,))
        if not (np.isfinite(R).all() and np.isfinite(t).all()):
            raise ParameterError("rotation, translation: must be finite")
        if np.abs(R @ R.T - np.eye(3)).max() > 1e-6 or np.linalg.det(R) < 0:
            raise ParameterError("rotation: not a proper rotation (orthonormal, det = +1)")
        object.__setattr__(self, "rotation", R)
        object.__setattr__(self, "translation", t)

    def apply(self, points: ArrayLike) -> Float64:
        """Points (…, 3) of the source frame in the target frame."""
        return np.asarray(np.asarray(points, np.float64) @ self.rotation.T + self.translation)

    def inverse(self) -> RigidTransform:
        """The motion back."""
        R = self.rotation.T
        return RigidTransform(R, -R @ self.translation, target=self.source, source=self.target)

    def __matmul__(self, other: RigidTransform) -> RigidTransform:
        if self.source != other.target:
            raise ParameterError(
                f"cannot compose {self.target}←{self.source} with {other.target}←{other.source}"
            )
        return RigidTransform(
            self.rotation @ other.rotation,
            self.rotation @ other.translation + self.translation,
            target=self.target,
            source=other.source,
        )

    @property
    def head_angles(self) -> tuple[float, float, float]:
        """Yaw, pitch, roll (rad) of the head, for a transform face←camera."""
        return se3.head_angles(self.rotation.T)
