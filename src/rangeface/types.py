"""The things that the stages hand to each other.

Lengths are mm, angles rad, amplitude sensor counts. The camera frame is x right, y down,
z forward; the face frame has the same axes for a frontal face and its origin at the nose
tip. Pixel (column u, row v) has its centre at the integer coordinates (u, v). An invalid
pixel is NaN in depth. Arrays are read-only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError, ParameterError
from rangeface.numerics import se3
from rangeface.numerics.projection import Projection

if TYPE_CHECKING:
    from pathlib import Path

Float32: TypeAlias = NDArray[np.float32]
Float64: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]

_F = TypeVar("_F", bound=Callable[..., Any])


def revision(number: int) -> Callable[[_F], _F]:
    """Mark a method's revision; raised by hand when, and only when, its numbers change.

    Parameters
    ----------
    number : int
        Revision, ≥ 1. A method without the mark has revision 1.

    Returns
    -------
    callable
        Decorator that returns the method itself.
    """

    def mark(method: _F) -> _F:
        method.revision = number  # type: ignore[attr-defined]
        return method

    return mark


def _frozen(
    array: ArrayLike, dtype: type, name: str, shape: tuple[int, ...] | None
) -> NDArray[Any]:
    out: NDArray[Any] = np.array(array, dtype=dtype, order="C")
    if shape is not None and out.shape != shape:
        raise ParameterError(f"{name}: shape {out.shape} does not match {shape}")
    out.flags.writeable = False
    return out


# ── cameras ──────────────────────────────────────────────────────────────────────────────


@dataclass(frozen=True)
class Pinhole:
    """A pinhole camera without distortion.

    Parameters
    ----------
    fx, fy : float
        Focal lengths, px, > 0.
    cx, cy : float
        Principal point, px; the centre of the first pixel is (0, 0).
    width, height : int
        Size of the image, px, ≥ 1.

    Raises
    ------
    ParameterError
        A focal length is not positive and finite, a principal point is not finite, a size < 1.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    def __post_init__(self) -> None:
        for name in ("fx", "fy"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise ParameterError(
                    f"{name}: focal length must be > 0 px, got {getattr(self, name)}"
                )
        _check_grid(self)

    def back_project(self, depth: ArrayLike) -> Float32:
        """Points of a depth image: (H, W) mm → (H, W, 3) mm, NaN where depth is."""
        z = np.asarray(depth, dtype=np.float32)
        u = ((np.arange(self.width) - self.cx) / self.fx).astype(np.float32)
        v = ((np.arange(self.height) - self.cy) / self.fy).astype(np.float32)
        return np.stack([z * u[None, :], z * v[:, None], z], axis=-1)

    def project(self, points: ArrayLike) -> Float64:
        """Pixel coordinates (…, 2) of points (…, 3) mm in the camera frame; NaN behind it."""
        p = np.asarray(points, dtype=np.float64)
        z = np.where(p[..., 2] > 0, p[..., 2], np.nan)
        return np.stack(
            [p[..., 0] / z * self.fx + self.cx, p[..., 1] / z * self.fy + self.cy], axis=-1
        )

    def radial_factor(self) -> Float32:
        """Radial range over depth, (H, W): the length of each pixel's ray at z = 1."""
        u = (np.arange(self.width) - self.cx) / self.fx
        v = (np.arange(self.height) - self.cy) / self.fy
        return np.sqrt(1.0 + u[None, :] ** 2 + v[:, None] ** 2).astype(np.float32)

    def pixel_mm(self, depth_mm: float) -> float:
        """Width of a pixel's footprint, mm, on a frontal surface at the given depth."""
        return float(depth_mm / np.sqrt(self.fx * self.fy))

    @property
    def projection(self) -> Projection:
        """The camera's parameters as the kernels take them."""
        return Projection(True, self.fx, self.fy, self.cx, self.cy)

    def crop(self, left: int, top: int, width: int, height: int) -> Pinhole:
        """The camera of the window whose first pixel is (left, top)."""
        return Pinhole(self.fx, self.fy, self.cx - left, self.cy - top, width, height)


@dataclass(frozen=True)
class Orthographic:
    """A parallel projection: every pixel is a square of `pitch_mm` at any depth.

    Parameters
    ----------
    pitch_mm : float
        Edge of a pixel, mm, > 0.
    cx, cy : float
        Pixel coordinates of the axis x = y = 0.
    width, height : int
        Size of the image, px, ≥ 1.

    Raises
    ------
    ParameterError
        The pitch is not positive and finite, a principal point is not finite, a size < 1.
    """

    pitch_mm: float
    cx: float
    cy: float
    width: int
    height: int

    def __post_init__(self) -> None:
        if not (np.isfinite(self.pitch_mm) and self.pitch_mm > 0):
            raise ParameterError(f"pitch_mm must be > 0, got {self.pitch_mm}")
        _check_grid(self)

    def back_project(self, depth: ArrayLike) -> Float32:
        """Points of a depth image: (H, W) mm → (H, W, 3) mm, NaN where depth is."""
        z = np.asarray(depth, dtype=np.float32)
        u = ((np.arange(self.width) - self.cx) * self.pitch_mm).astype(np.float32)
        v = ((np.arange(self.height) - self.cy) * self.pitch_mm).astype(np.float32)
        hole = z * 0.0  # NaN where depth is, so that a hole has no x and y either
        return np.stack([hole + u[None, :], hole + v[:, None], z], axis=-1)

    def project(self, points: ArrayLike) -> Float64:
        """Pixel coordinates (…, 2) of points (…, 3) mm in the camera frame."""
        p = np.asarray(points, dtype=np.float64)
        return p[..., :2] / self.pitch_mm + np.array([self.cx, self.cy])

    def radial_factor(self) -> Float32:
        """Ones (H, W): along parallel rays range is depth."""
        return np.ones((self.height, self.width), dtype=np.float32)

    def pixel_mm(self, depth_mm: float) -> float:
        """Width of a pixel's footprint, mm: the pitch at every depth."""
        return float(self.pitch_mm)

    @property
    def projection(self) -> Projection:
        """The camera's parameters as the kernels take them."""
        return Projection(False, 1.0 / self.pitch_mm, 1.0 / self.pitch_mm, self.cx, self.cy)

    def crop(self, left: int, top: int, width: int, height: int) -> Orthographic:
        """The camera of the window whose first pixel is (left, top)."""
        return Orthographic(self.pitch_mm, self.cx - left, self.cy - top, width, height)


Camera: TypeAlias = Pinhole | Orthographic


def _check_grid(camera: Camera) -> None:
    for name in ("cx", "cy"):
        if not np.isfinite(getattr(camera, name)):
            raise ParameterError(f"{name}: must be finite, got {getattr(camera, name)}")
    for name in ("width", "height"):
        if getattr(camera, name) < 1:
            raise ParameterError(f"{name}: must be ≥ 1 px, got {getattr(camera, name)}")


# ── images and points ────────────────────────────────────────────────────────────────────


@dataclass(frozen=True, eq=False)
class RangeImage:
    """A depth image with its camera, and what is known of its noise.

    Parameters
    ----------
    depth : (H, W) array_like
        Depth z, mm; NaN marks an invalid pixel. Stored as read-only float32.
    camera : Pinhole or Orthographic
        Of the same size.
    sigma : (H, W) array_like, optional
        Standard deviation of the depth, mm, per pixel.
    amplitude : (H, W) array_like, optional
        Amplitude of the received light, sensor counts.
    filled : (H, W) array_like of bool, optional
        Pixels whose depth was not measured but filled in (denoising, mirroring, reference).

    Raises
    ------
    ParameterError
        A size differs from the camera's, or a depth is infinite.

    Examples
    --------
    >>> image = RangeImage([[400.0, np.nan]], Pinhole(200, 200, 0.5, 0, 2, 1))
    >>> image.mask
    array([[ True, False]])
    >>> image.points[0, 0]
    array([ -1.,   0., 400.], dtype=float32)
    """

    depth: Float32
    camera: Camera
    sigma: Float32 | None = None
    amplitude: Float32 | None = None
    filled: Mask | None = None

    def __post_init__(self) -> None:
        shape = (self.camera.height, self.camera.width)
        object.__setattr__(self, "depth", _frozen(self.depth, np.float32, "depth", shape))
        if np.isinf(self.depth).any():
            raise ParameterError("depth: infinite values; mark invalid pixels with NaN")
        for name, dtype in (("sigma", np.float32), ("amplitude", np.float32), ("filled", np.bool_)):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _frozen(value, dtype, name, shape))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.camera.height, self.camera.width

    @cached_property
    def mask(self) -> Mask:
        """Which pixels are valid, (H, W) bool."""
        mask = np.isfinite(self.depth)
        mask.flags.writeable = False
        return mask

    @cached_property
    def points(self) -> Float32:
        """Points in the camera frame, (H, W, 3) mm, NaN where invalid."""
        points = self.camera.back_project(self.depth)
        points.flags.writeable = False
        return points

    def with_depth(self, depth: ArrayLike, **changes: Any) -> RangeImage:
        """The same image with another depth, and with any other field changed."""
        return replace(self, depth=np.asarray(depth, np.float32), **changes)

    def masked(self, keep: ArrayLike) -> RangeImage:
        """The same image with everything outside `keep` (H, W bool) made invalid."""
        return replace(self, depth=np.where(np.asarray(keep, dtype=bool), self.depth, np.nan))

    def crop(self, left: int, top: int, width: int, height: int) -> RangeImage:
        """The window whose first pixel is (left, top), clipped to the image, with its camera.

        Raises
        ------
        ParameterError
            The window lies outside the image.
        """
        rows = slice(max(top, 0), min(top + height, self.camera.height))
        cols = slice(max(left, 0), min(left + width, self.camera.width))
        h, w = rows.stop - rows.start, cols.stop - cols.start
        if h < 1 or w < 1:
            raise ParameterError(
                f"crop: window ({left}, {top}, {width}, {height}) is outside the image"
            )
        planes = {
            name: None if (plane := getattr(self, name)) is None else plane[rows, cols]
            for name in ("sigma", "amplitude", "filled")
        }
        camera = self.camera.crop(cols.start, rows.start, w, h)
        return RangeImage(self.depth[rows, cols], camera, **planes)


@dataclass(frozen=True, eq=False)
class PointSet:
    """Points, and triangles between them if the source had any.

    Parameters
    ----------
    points : (n, 3) array_like
        Points, mm, all finite, in the camera frame's axes (x right, y down, z forward).
    triangles : (m, 3) array_like of int, optional
        Indices into `points`, all in range.

    Raises
    ------
    ParameterError
        A shape is wrong, a point is not finite, or an index is out of range.
    """

    points: Float32
    triangles: NDArray[np.int32] | None = None

    def __post_init__(self) -> None:
        points = _frozen(self.points, np.float32, "points", None)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ParameterError(f"points: expected (n, 3), got {points.shape}")
        if not np.isfinite(points).all():
            raise ParameterError("points: not all finite; drop invalid points first")
        object.__setattr__(self, "points", points)
        if self.triangles is not None:
            triangles = _frozen(self.triangles, np.int32, "triangles", None)
            if triangles.ndim != 2 or triangles.shape[1] != 3:
                raise ParameterError(f"triangles: expected (m, 3), got {triangles.shape}")
            if triangles.size and (triangles.min() < 0 or triangles.max() >= len(points)):
                raise ParameterError("triangles: an index is outside the points")
            object.__setattr__(self, "triangles", triangles)


# ── poses ────────────────────────────────────────────────────────────────────────────────


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
        R = _frozen(self.rotation, np.float64, "rotation", (3, 3))
        t = _frozen(self.translation, np.float64, "translation", (3,))
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


class Reason(StrEnum):
    """The closed list of reasons for which a face is refused or a decision withheld."""

    NO_VALID_PIXELS = "no valid pixels"
    NO_FACE = "no face found"
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
        object.__setattr__(self, "nose_tip", _frozen(self.nose_tip, np.float64, "nose_tip", (3,)))
        candidates = _frozen(self.candidates, np.float64, "candidates", None)
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
        usable = np.isfinite(self.normals[..., 2])
        stride = max(float(np.sqrt(usable.sum() / count)), 1.0)
        rows, cols = (np.arange(0.5 * (stride - 1.0), n, stride).astype(int) for n in usable.shape)
        lattice = np.zeros_like(usable)
        lattice[np.ix_(rows, cols)] = True
        chosen = usable & lattice
        weights = np.ones(int(chosen.sum()), np.float32)
        if self.image.sigma is not None:
            sigma = self.image.sigma
            weights = 1.0 / (1.0 + (sigma[chosen] / np.median(sigma[usable])) ** 2)
        return (
            np.ascontiguousarray(self.image.points[chosen]),
            np.ascontiguousarray(self.normals[chosen]),
            np.ascontiguousarray(weights, dtype=np.float32),
        )


# ── scans, templates, decisions ──────────────────────────────────────────────────────────


@dataclass(frozen=True, eq=False)
class Scan:
    """One capture of a database: who, when, how, and how to load it.

    Parameters
    ----------
    path : Path
        The file, or the folder of a sequence.
    loader : callable
        Reads `path`: one image, or the frames of a sequence; raises ScanError.
    subject : str
        Who it shows.
    role : str
        "train", "gallery", "probe" or "" (the protocol decides).
    session, view, expression, sensor : str
        As the database says; "" where it does not.
    landmarks : mapping of str to (3,) array
        Landmarks that the database gives, camera frame, mm.
    """

    path: Path
    loader: Callable[[Path], RangeImage | list[RangeImage]] = field(repr=False)
    subject: str = ""
    role: str = ""
    session: str = ""
    view: str = ""
    expression: str = ""
    sensor: str = ""
    landmarks: Mapping[str, Float64] = field(default_factory=dict)

    def load(self) -> RangeImage | list[RangeImage]:
        """Read the capture: one image, or the frames of a sequence.

        Raises
        ------
        ScanError
            The file is missing or broken; the message names it.
        """
        return self.loader(self.path)


@dataclass(frozen=True, eq=False)
class Template:
    """What is stored of a face: per head, one row for every view of it.

    Parameters
    ----------
    vectors : tuple of (k, D) arrays
        One array a head of the pipeline, in its order.
    fingerprint : str
        Of the fitted pipeline that made it; templates of others do not compare.
    assessment : Assessment, optional
        Quality of the capture.
    """

    vectors: tuple[Float32, ...]
    fingerprint: str
    assessment: Assessment | None = None

    def __post_init__(self) -> None:
        frozen = tuple(_frozen(v, np.float32, "vectors", None) for v in self.vectors)
        object.__setattr__(self, "vectors", frozen)


class Verdict(StrEnum):
    """The three answers that a decision can give."""

    ACCEPTED = "accepted"
    UNKNOWN = "unknown"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class Decision:
    """The answer to "who is this?" or "is this X?".

    Parameters
    ----------
    verdict : Verdict
        Accepted, unknown, or cannot tell.
    subject : str, optional
        Who was recognised; None unless accepted.
    score : float
        Best score; NaN where nothing could be compared.
    threshold : float
        The score that was needed.
    reason : Reason, optional
        Why it was not accepted.
    ranking : tuple of (str, float)
        The best subjects and their scores, best first.
    """

    verdict: Verdict
    subject: str | None = None
    score: float = float("nan")
    threshold: float = float("nan")
    reason: Reason | None = None
    ranking: tuple[tuple[str, float], ...] = ()
