"""A face on its way: found, aligned, assessed; and the face that it is aligned to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property, lru_cache
from types import MappingProxyType

import numpy as np

from rangeface.errors import DegenerateError, ParameterError
from rangeface.types._arrays import Float32, Float64, frozen
from rangeface.types._cameras import Orthographic
from rangeface.types._images import RangeImage
from rangeface.types._poses import RigidTransform


class Reason(StrEnum):
    """The closed list of reasons for which a face is refused or a decision withheld."""

    NO_VALID_PIXELS = "no valid pixels"
    NO_FACE = "no face found"
    LOST = "face lost"
    TOO_FEW_POINTS = "too few points"
    NOT_CONVERGED = "registration did not converge"
    POOR_FIT = "surface does not fit a face"
    LOW_OVERLAP = "too little of the face is visible"
    POSE = "head turned too far"
    TOO_NOISY = "too noisy"
    DISTANCE = "distance outside the working range"
    BELOW_THRESHOLD = "no score above the threshold"
    AMBIGUOUS = "two people score alike"
    EMPTY_GALLERY = "nobody enrolled"
    TOO_FEW_FRAMES = "too few usable frames"


@dataclass(frozen=True, eq=False)
class Face:
    """A face found in an image, before registration.

    Parameters
    ----------
    image : RangeImage
        The crop around the face (everything outside the crop invalid), with its camera.
    nose_tip : (3,) array_like
        Nose tip in the camera frame, mm.
    landmarks : mapping of str to (3,) array
        Other landmarks, camera frame, mm (nose_root, left_eye_outer, chin, …).
    candidates : (k, 3) array_like
        Other places for the nose tip, best first, mm.
    confidence : float
        0 … 1: how sure it is that this is a face.
    pose : RigidTransform, optional
        Rough pose face←camera, where the finder had to estimate one.
    """

    image: RangeImage
    nose_tip: Float64
    landmarks: Mapping[str, Float64] = field(default_factory=dict)
    candidates: Float64 = field(default_factory=lambda: np.empty((0, 3)))
    confidence: float = 1.0
    pose: RigidTransform | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "nose_tip", frozen(self.nose_tip, np.float64, "nose_tip", (3,)))
        candidates = frozen(self.candidates, np.float64, "candidates", None)
        object.__setattr__(self, "candidates", candidates)
        object.__setattr__(self, "landmarks", MappingProxyType(dict(self.landmarks)))


class Faces(list[Face]):
    """The faces of one image, most confident first; an empty list says why.

    Parameters
    ----------
    faces : iterable of Face
        The faces found.
    reason : Reason, optional
        Why there is none.
    """

    def __init__(
        self, faces: list[Face] | tuple[Face, ...] = (), reason: Reason | None = None
    ) -> None:
        super().__init__(faces)
        self.reason = reason if not self else None


@dataclass(frozen=True, eq=False)
class Alignment:
    """How a face lies in the frontal frame, and how well that is known.

    Parameters
    ----------
    transform : RigidTransform
        T_face_camera.
    rms_mm : float
        Root mean square of the inliers' residuals, mm.
    overlap : float
        0 … 1: the part of the reference face that the data explain.
    inliers : int
        Number of points that carry the fit.
    condition : float
        Condition number of the last normal equations (lengths scaled to comparable size).
    converged : bool
        False: refused, `reason` says why; the transform must not be used.
    reason : Reason, optional
        Why it was refused.
    correlation : float
        −1 … 1: correlation of the surface's relief with the reference's.
    """

    transform: RigidTransform
    rms_mm: float = float("nan")
    overlap: float = float("nan")
    inliers: int = 0
    condition: float = float("nan")
    converged: bool = True
    reason: Reason | None = None
    correlation: float = float("nan")


@dataclass(frozen=True)
class Assessment:
    """What a recogniser should know before it trusts a face.

    Parameters
    ----------
    yaw_deg, pitch_deg, roll_deg : float
        Pose of the head, degrees.
    coverage : float
        0 … 1: measured (not filled) part of the frontal grid.
    overlap : float
        0 … 1: as in `Alignment`.
    sigma_mm : float
        Median standard deviation of the depth on the face, mm; NaN where unknown.
    distance_mm : float
        Depth of the nose tip, mm.
    rms_mm : float
        Residual of the registration, mm.
    correlation : float
        As in `Alignment`.
    refusals : tuple of Reason
        Every limit that is exceeded; empty = fit for a decision.
    """

    yaw_deg: float
    pitch_deg: float
    roll_deg: float
    coverage: float
    overlap: float
    sigma_mm: float
    distance_mm: float
    rms_mm: float
    correlation: float
    refusals: tuple[Reason, ...] = ()

    @property
    def usable(self) -> bool:
        """Whether nothing speaks against a decision."""
        return not self.refusals


@dataclass(frozen=True, eq=False)
class ReferenceFace:
    """A frontal mean face on an organised grid: what registration aligns to.

    Parameters
    ----------
    image : RangeImage
        Orthographic, in the face frame: nose tip at (0, 0, 0). Its `sigma` is how much people
        and expressions differ there, mm.
    landmarks : mapping of str to (3,) array
        Landmarks in the face frame, mm.
    name : str
        Where it comes from.
    """

    image: RangeImage
    landmarks: Mapping[str, Float64] = field(default_factory=dict)
    name: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.image.camera, Orthographic):
            raise ParameterError("image: a reference face needs an orthographic camera")
        if self.image.mask.sum() < 100:
            raise DegenerateError("image: a reference face needs at least 100 valid pixels")
        object.__setattr__(self, "landmarks", MappingProxyType(dict(self.landmarks)))

    @cached_property
    def normals(self) -> Float32:
        """Unit normals towards the camera, (H, W, 3), NaN where there is none."""
        from rangeface.numerics.normals import from_points  # numba loads only where it is needed

        return from_points(self.image.points)

    def surface(self, count: int) -> tuple[Float32, Float32, Float32]:
        """About `count` points (m, 3), unit normals (m, 3) and weights (m,), evenly spread.

        A point weighs 1/(1 + σ²/σ₀²) with σ₀ the median of `image.sigma`: where people differ
        most, the reference says least.
        """
        return _surface(self, count)


@lru_cache(maxsize=32)  # every scan asks for the same few
def _surface(reference: ReferenceFace, count: int) -> tuple[Float32, Float32, Float32]:
    image, usable = reference.image, np.isfinite(reference.normals[..., 2])
    stride = max(float(np.sqrt(usable.sum() / count)), 1.0)
    rows, cols = (np.arange(0.5 * (stride - 1.0), n, stride).astype(int) for n in usable.shape)
    lattice = np.zeros_like(usable)
    lattice[np.ix_(rows, cols)] = True
    chosen = usable & lattice
    weights = np.ones(int(chosen.sum()), np.float32)
    if image.sigma is not None:
        weights = 1.0 / (1.0 + (image.sigma[chosen] / np.median(image.sigma[usable])) ** 2)
    return (
        frozen(image.points[chosen], np.float32, "points", None),
        frozen(reference.normals[chosen], np.float32, "normals", None),
        frozen(weights, np.float32, "weights", None),
    )
