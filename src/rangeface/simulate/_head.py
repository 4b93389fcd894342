"""A person's head: seeded, always the same for the same number, no two alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError
from rangeface.simulate import _dress
from rangeface.simulate._anatomy import Field, Tissue, mean_anatomy
from rangeface.simulate._gesture import gesture
from rangeface.simulate._identity import ASYMMETRY, FACTORS, basis, hair_volume, tendencies
from rangeface.simulate._relief import relief
from rangeface.types import Float64, PointSet

# near-infrared (850 nm) reflectivity, relative to white; skin after Simpson et al., Phys. Med.
# Biol. 43(9), 1998, doi:10.1088/0031-9155/43/9/003; the others are assumed
REFLECTIVITY: Mapping[Tissue, float] = MappingProxyType(
    {Tissue.SKIN: 0.60, Tissue.HAIR: 0.28, Tissue.EYE: 0.30, Tissue.CLOTH: 0.50,
     Tissue.FRAME: 0.08}
)  # fmt: skip

# mirror-like part: a wet cornea returns the lamp's image (assumed strength)
SHINE = np.array([{Tissue.EYE: 0.6}.get(t, 0.0) for t in Tissue], np.float32)

# root mean square (mm) and shortest and longest wavelength (mm) of the individual relief
RELIEF = ((0.6, 45.0, 110.0), (0.15, 14.0, 45.0))
_DAILY = (0.15, 10.0, 40.0)  # the same for what changes from day to day
_BEARD = (2.0, 12.0)  # its length, mm
_FRINGE = (-92.0, -66.0)  # the level that it reaches down to, mm

# where the landmarks of the mean head lie in the frontal view, mm
_LANDMARKS = {
    "nose_tip": (0.0, -0.5), "nose_root": (0.0, -41.0), "subnasale": (0.0, 14.0),
    "left_eye_inner": (16.5, -37.0), "left_eye_outer": (46.0, -37.0),
    "right_eye_inner": (-16.5, -37.0), "right_eye_outer": (-46.0, -37.0),
    "left_alare": (17.0, 3.0), "right_alare": (-17.0, 3.0),
    "left_mouth_corner": (26.0, 32.5), "right_mouth_corner": (-26.0, 32.5),
    "upper_lip": (0.0, 27.0), "lower_lip": (0.0, 37.5), "chin": (0.0, 62.0),
    "gnathion": (0.0, 78.0),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Head:
    """A head in the face frame, and what its surface is made of.

    Parameters
    ----------
    surface : PointSet
        Vertices (mm; nose tip at the origin, x right, y down, z into the head) and triangles.
    tissue : (n,) int8
        `Tissue` of each vertex.
    reflectivity : (n,) float32
        Near-infrared reflectivity of each vertex, 0 … 1.
    landmarks : mapping of str to (3,) array
        Landmarks in the face frame, mm.
    name : str
        Who it is.
    """

    surface: PointSet
    tissue: NDArray[np.int8]
    reflectivity: NDArray[np.float32]
    landmarks: Mapping[str, Float64] = field(default_factory=dict)
    name: str = ""

    def __post_init__(self) -> None:
        for name, dtype in (("tissue", np.int8), ("reflectivity", np.float32)):
            array = np.array(getattr(self, name), dtype=dtype)
            if array.shape != self.surface.points.shape[:1]:
                raise ParameterError(f"{name}: one value a vertex needed, got {array.shape}")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        object.__setattr__(self, "landmarks", MappingProxyType(dict(self.landmarks)))


def mean_head() -> Head:
    """The mean head of the population: the face that registration aligns to.

    Returns
    -------
    Head
        Neutral, symmetric, with the sizes of the cited surveys.

    Examples
    --------
    >>> landmarks = mean_head().landmarks
    >>> height = landmarks["gnathion"][1] - landmarks["nose_root"][1]
    >>> bool(abs(height - 118) < 3)
    True
    """
    return _finish(
        mean_anatomy().points, mean_anatomy().tissue, REFLECTIVITY[Tissue.HAIR], 1.0, "mean"
    )


def head(
    seed: int,
    *,
    expression: str = "neutral",
    strength: float = 1.0,
    session: int = 0,
    sex: str | None = None,
    age: float | None = None,
    glasses: bool = False,
    beard: bool = False,
    fringe: bool = False,
) -> Head:
    """The head of person number `seed`.

    Parameters
    ----------
    seed : int
        Number of the person, ≥ 0. The same number is always the same head.
    expression : str
        "neutral", "smile", "laugh" (mouth open), "frown", "surprise", or "random": a gesture that
        changes with `session`.
    strength : float
        0 … 1.5 of the expression.
    session : int
        Number of the visit, ≥ 0: hair, weight and skin change a little from visit to visit.
    sex : {"female", "male"}, optional
        Default: drawn.
    age : float, optional
        Years, 18 … 90. Default: drawn between 20 and 70.
    glasses, beard, fringe : bool
        What the person wears; its form is the person's own.

    Returns
    -------
    Head
        In the face frame.

    Raises
    ------
    ParameterError
        A negative seed or session, an unknown sex or expression, an age or strength out of range.

    Examples
    --------
    >>> float(np.abs(head(7).surface.points - head(7).surface.points).max())
    0.0
    >>> laughing = head(7, expression="laugh").landmarks
    >>> float(np.round(laughing["chin"][1] - head(7).landmarks["chin"][1])) > 8
    True
    """
    _check(seed, session, sex, age)
    person = _person(seed, sex, age)
    visit = np.random.default_rng([seed, session, 0x5E55])
    points = person.points + (_change(visit) if session else 0.0)
    points += gesture(expression, strength, person=seed, rng=visit)
    tissue = mean_anatomy().tissue.copy()
    own = np.random.default_rng([seed, 0xD2E5])
    for worn, grow, (low, high) in (
        (beard, _dress.beard, _BEARD),
        (fringe, _dress.fringe, _FRINGE),
    ):
        amount = own.uniform(low, high)
        if worn:
            off, where = grow(mean_anatomy(), amount, own)
            points += off
            tissue[where > 0.5] = Tissue.HAIR
    made = _finish(points, tissue, person.hair, person.skin, f"person {seed}")
    return _with_glasses(made, own) if glasses else made


@dataclass(frozen=True, eq=False)
class _Person:
    """What stays the same from visit to visit: neutral shape, and reflectivities."""

    points: Field
    hair: float
    skin: float


@lru_cache(maxsize=64)
def _person(seed: int, sex: str | None, age: float | None) -> _Person:
    rng = np.random.default_rng([seed, 0x4EAD])
    anatomy = mean_anatomy()
    weights = _weights(rng, sex, age)
    points = anatomy.points + np.einsum("k,k...", weights.astype(np.float32), basis())
    points[:, 2] -= sum(relief(anatomy, *band, rng=rng) for band in RELIEF)
    return _Person(
        points, rng.uniform(0.15, 0.45), float(np.clip(rng.normal(1.0, 0.08), 0.75, 1.25))
    )


def _change(visit: np.random.Generator) -> Field:
    """What is different on another day: weight, hair, and the skin's fine relief."""
    change = visit.normal(0.0, 0.12) * _stoutness() + visit.normal(0.0, 3.0) * _hair()
    change[:, 2] -= relief(mean_anatomy(), *_DAILY, rng=visit)
    return change


@lru_cache(maxsize=1)
def _stoutness() -> Field:
    return np.einsum("k,k...", tendencies()[2], basis())


@lru_cache(maxsize=1)
def _hair() -> Field:
    return hair_volume(mean_anatomy())


def _check(seed: int, session: int, sex: str | None, age: float | None) -> None:
    if seed < 0 or session < 0:
        raise ParameterError(f"seed, session: must be ≥ 0, got {seed}, {session}")
    if sex not in (None, "female", "male"):
        raise ParameterError(f"sex: must be 'female' or 'male', got {sex!r}")
    if age is not None and not 18 <= age <= 90:
        raise ParameterError(f"age: must be 18 … 90 years, got {age}")


def _weights(rng: np.random.Generator, sex: str | None, age: float | None) -> Field:
    # everything is drawn in a fixed order, so that a given sex or age changes nothing else
    drawn_sex, drawn_age = rng.random(), 20.0 + 50.0 * rng.random()
    stoutness = float(np.clip(rng.normal(), -2.0, 2.5))
    own = np.clip(rng.normal(size=len(FACTORS) + len(ASYMMETRY)), -2.8, 2.8)
    male, decade, stout = tendencies()
    manly = 1.0 if (sex or ("male" if drawn_sex < 0.5 else "female")) == "male" else -1.0
    years = drawn_age if age is None else age
    return own + manly * male + (years - 35.0) / 10.0 * decade + stoutness * stout


def _finish(points: Field, tissue: NDArray[np.int8], hair: float, skin: float, name: str) -> Head:
    anatomy = mean_anatomy()
    tip = _nose_tip(points)
    surface = PointSet((points - tip).astype(np.float32), anatomy.triangles)
    reflectivity = np.array([REFLECTIVITY[t] for t in Tissue])
    reflectivity[Tissue.HAIR] = hair
    reflectivity[Tissue.SKIN] *= skin
    landmarks = {
        name: surface.points[index].astype(np.float64)
        for name, index in _landmark_vertices().items()
    } | {"nose_tip": np.zeros(3)}
    return Head(surface, tissue, reflectivity[tissue], landmarks, name)


def _with_glasses(bare: Head, rng: np.random.Generator) -> Head:
    mark = bare.landmarks
    left, right = (
        0.5 * (mark[f"{side}_eye_inner"] + mark[f"{side}_eye_outer"]) for side in ("left", "right")
    )
    old = bare.surface
    near_ears = np.abs(old.points[:, 1] - mark["nose_root"][1]) < 6.0
    ahead = near_ears & (old.points[:, 2] < 85.0)
    side_x = float(np.abs(old.points[ahead, 0]).max())
    points, triangles, tissue = _dress.spectacles((left, right), mark["nose_root"], side_x, rng)
    assert old.triangles is not None  # a head is always a mesh
    surface = PointSet(
        np.concatenate([old.points, points.astype(np.float32)]),
        np.concatenate([old.triangles, triangles + len(old.points)]),
    )
    dark = np.full(len(points), REFLECTIVITY[Tissue.FRAME], np.float32)
    return Head(
        surface, np.concatenate([bare.tissue, tissue]),
        np.concatenate([bare.reflectivity, dark]), mark, bare.name,
    )  # fmt: skip


def _nose_tip(points: Field) -> Field:
    a = mean_anatomy()
    near = np.flatnonzero((np.abs(a.x) < 9) & (np.abs(a.y) < 10) & (a.front > 0))
    return points[near[np.argmin(points[near, 2])]]


@lru_cache(maxsize=1)
def _landmark_vertices() -> dict[str, int]:
    a = mean_anatomy()
    hidden = np.where(np.cos(a.theta) > 0, 0.0, 1e3)
    return {
        name: int(np.argmin(np.hypot(a.x - x, a.y - y) + hidden))
        for name, (x, y) in _LANDMARKS.items()
    }
