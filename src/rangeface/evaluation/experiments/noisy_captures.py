"""People before a time-of-flight camera, with and without noise: what experiments start from.

Every person has four captures: neutral and smiling (for training), neutral on another day and
laughing (probes). The same numbers always give the same captures. An experiment reads what it
needs: a capture clean, or `observed` through noise and a denoiser.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from rangeface import register
from rangeface.evaluation.experiments.sources import Source
from rangeface.numerics.se3 import rotation_matrix
from rangeface.pipeline import Step
from rangeface.simulate import head, mean_head, render
from rangeface.types import (
    Alignment,
    Face,
    Float32,
    Pinhole,
    PointSet,
    RangeImage,
    ReferenceFace,
    RigidTransform,
)

# σ that a clean scan states: every scan of a sensor has one, and normals weigh by it
QUIET_MM = 0.01

ROLES = ("neutral", "smile", "neutral again", "laugh")
TRAINING = ROLES[:2]
# time of flight at arm's length: 2 mm a pixel
_CAMERA = Pinhole(200.0, 200.0, 87.5, 71.5, 176, 144)
_DISTANCE_MM = 400.0

Surfaces: TypeAlias = Callable[[int, str, np.random.Generator], PointSet]


class Noise(NamedTuple):
    """Where the noise enters ("crop", "scan" or "tof") and its σ (at the median pixel), mm."""

    site: str
    sigma_mm: float


# ── populations ──────────────────────────────────────────────────────────────────────────


def ict_heads(path: Path) -> Surfaces:
    """People of the ICT-FaceKit model (the npz of the development data) by number."""
    with np.load(path) as model:
        mean, identity, expression = (model[k] for k in ("mean", "ident", "expr"))
        triangles, names = model["tri"], [str(name) for name in model["expr_names"]]
        tip = int(model["lm68"][30])
    smile = {"mouthSmile_L": 0.6, "mouthSmile_R": 0.5, "cheekSquint_L": 0.3, "cheekSquint_R": 0.3}
    laugh = {**smile, "mouthSmile_L": 1.0, "mouthSmile_R": 0.9, "jawOpen": 0.45}
    faces: dict[str, dict[str, float]] = {"smile": smile, "laugh": laugh}

    def surface(person: int, role: str, rng: np.random.Generator) -> PointSet:
        own = np.random.default_rng([3, person])
        w = np.clip(own.normal(size=len(identity)), -2.8, 2.8)
        # nobody holds still twice: a trace of every expression, another at each capture
        v = np.abs(rng.normal(0.0, 0.05, len(names)))
        for name, strength in faces.get(role, {}).items():
            v[names.index(name)] += strength * rng.uniform(0.8, 1.2)
        points = mean + 0.01 * (np.tensordot(w, identity, 1) + np.tensordot(v, expression, 1))
        return PointSet((points - points[tip]) * [1.0, -1.0, -1.0], triangles)

    return surface


def own_heads() -> Surfaces:
    """People of `rangeface.simulate` by number; both probes are taken on another day."""

    def surface(person: int, role: str, rng: np.random.Generator) -> PointSet:
        expression, day = role.removesuffix(" again"), int(role not in TRAINING)
        return head(person, expression=expression, session=day).surface

    return surface


# ── captures ─────────────────────────────────────────────────────────────────────────────


class Capture(NamedTuple):
    """A clean scan, where the registration (not quite) puts the face, and the crop."""

    scan: RangeImage
    alignment: Alignment
    frontal: RangeImage


@lru_cache(maxsize=2)
def captures(source: Source) -> dict[str, list[Capture]]:
    """All captures of the people of a source by role."""
    surfaces = ict_heads(Path(source.folder)) if source.kind == "ict" else own_heads()
    return {
        role: [taken(surfaces, person, number) for person in source.numbers]
        for number, role in enumerate(ROLES)
    }


def taken(surfaces: Surfaces, person: int, number: int) -> Capture:
    """Capture `number` (of `ROLES`) of a person, who stands about 40 cm before the camera."""
    rng = np.random.default_rng([1, person, number])
    surface = surfaces(person, ROLES[number], rng)
    turn = rotation_matrix(np.deg2rad(rng.normal(0.0, 4.0, 3)))
    T_camera_face = RigidTransform(
        turn, np.array([*rng.normal(0.0, 10.0, 2), _DISTANCE_MM]), "camera", "face"
    )
    scene = render(surface, _CAMERA, T_camera_face)
    # light falls off with the square of the distance and the cosine of incidence
    cosine = np.clip(-scene.normal[..., 2], 0.05, 1.0)
    amplitude = np.nan_to_num(cosine * (_DISTANCE_MM / scene.depth) ** 2)
    quiet = np.full(scene.depth.shape, QUIET_MM)
    scan = RangeImage(scene.depth, _CAMERA, sigma=quiet, amplitude=amplitude)
    # a registration is wrong by about a degree and a millimetre
    slip = rotation_matrix(np.deg2rad(rng.normal(0.0, 0.8, 3)))
    T = T_camera_face.inverse()
    moved = slip @ T.translation + rng.normal(0.0, 0.7, 3)
    alignment = Alignment(RigidTransform(slip @ T.rotation, moved))
    return Capture(scan, alignment, frontal(scan, alignment))


def frontal(scan: RangeImage, alignment: Alignment) -> RangeImage:
    """The crop of a scan: 80 × 50 pixels of 2.8 mm."""
    nose = alignment.transform.inverse().translation
    return register.frontal.resample(Face(scan, nose), alignment, reference=_reference())


@lru_cache(maxsize=1)
def _reference() -> ReferenceFace:
    camera = register.frontal.grid(140.0, 224.0, 50, 80)
    return ReferenceFace(render(mean_head(), camera).image, name="mean head")


def observed(
    capture: Capture, noise: Noise, denoiser: Step, rng: np.random.Generator
) -> RangeImage:
    """The frontal image of a capture after noise and denoising, in the order of the site."""
    if noise.site == "crop":
        return denoiser(noisy(capture.frontal, noise.sigma_mm, rng))
    scan = capture.scan
    sigma: Float32 | float = noise.sigma_mm
    if noise.site == "tof":
        assert scan.amplitude is not None
        A = np.maximum(scan.amplitude, 1e-3)
        sigma = noise.sigma_mm * np.median(A[scan.mask]) / A
    return frontal(denoiser(noisy(scan, sigma, rng)), capture.alignment)


def noisy(image: RangeImage, sigma: Float32 | float, rng: np.random.Generator) -> RangeImage:
    """The image with Gaussian noise of this σ, mm, which it then states."""
    noise = sigma * rng.standard_normal(image.shape)
    return image.with_depth(image.depth + noise, sigma=np.broadcast_to(sigma, image.shape))
