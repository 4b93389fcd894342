"""The cells that experiments are made of: scans, frontal crops, noise on them, recognition."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rangeface import denoise, register, segment
from rangeface.evaluation.experiments.sources import Source, scans_of
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.numerics.se3 import rotation_matrix
from rangeface.pipeline import Step, step
from rangeface.simulate import add_noise
from rangeface.types import (
    Alignment,
    Float32,
    Orthographic,
    Pinhole,
    RangeImage,
    RigidTransform,
)

#: The paper's twelve additional images: about each axis, degrees.
TURNS_DEG = (-5.0, -2.5, 2.5, 5.0)

#: Stages of failure, as `crops` counts them.
ACQUIRED, NO_FACE, NOT_REGISTERED = 0, 1, 2

NONE = step(denoise.none)
SLICES = step(segment.slices)


class Crop(NamedTuple):
    """What is cut around the nose tip, on 80 × 50 pixels: extent and sphere, mm."""

    width_mm: float
    height_mm: float
    radius_mm: float = 140.0
    fill: bool = True

    @property
    def pitch_mm(self) -> float:
        """Edge of a pixel, mm."""
        return self.width_mm / 50.0

    def step(self) -> Step:
        """The resampling onto this crop."""
        return step(register.frontal.resample, **self._asdict())


RECTANGLE = Crop(100.0, 160.0)
SPHERE = Crop(175.0, 280.0, fill=False)
WIDE = Crop(140.0, 224.0)


# ── scans ────────────────────────────────────────────────────────────────────────────────


@kept
def scans(store: Store, *, source: Source, view: str) -> Arrays:
    """All scans of a view, packed."""
    found = scans_of(source, view)
    return {"owner": np.array([person for person, _ in found]), **pack(i for _, i in found)}


def pack(images: Any) -> dict[str, NDArray[Any]]:
    """Range images of any size as named arrays."""
    arrays: dict[str, NDArray[Any]] = {}
    for number, image in enumerate(images):
        c = image.camera
        numbers = (
            (c.pitch_mm, c.cx, c.cy) if isinstance(c, Orthographic) else (c.fx, c.fy, c.cx, c.cy)
        )
        arrays[f"{number}.camera"] = np.array(numbers)
        for plane in ("depth", "sigma", "amplitude"):
            if (values := getattr(image, plane)) is not None:
                arrays[f"{number}.{plane}"] = values
    return arrays


def unpack(arrays: Arrays, number: int) -> RangeImage:
    """Range image `number` of those that were packed."""
    depth, numbers = arrays[f"{number}.depth"], arrays[f"{number}.camera"]
    height, width = depth.shape
    planes = {p: arrays.get(f"{number}.{p}") for p in ("sigma", "amplitude")}
    if len(numbers) == 3:
        pitch, cx, cy = map(float, numbers)
        return RangeImage(depth, Orthographic(pitch, cx, cy, width, height), **planes)
    fx, fy, cx, cy = map(float, numbers)
    return RangeImage(depth, Pinhole(fx, fy, cx, cy, width, height), **planes)


# ── frontal crops ────────────────────────────────────────────────────────────────────────


@kept
def crops(
    store: Store,
    *,
    scans: Cell,
    frontal: Step,
    register: Step,
    turns_deg: tuple[float, ...] = (),
    segment: Step = SLICES,
) -> Arrays:
    """Frontal images of scans: find, register, turn, resample.

    Returns
    -------
    dict
        "depth", "sigma" (n, k, H, W) mm: k = 1 + 3 · len(turns_deg) views, NaN where there is
        nothing; "pitch_mm"; "owner" (n,); "stage" (n,): how far each came.
    """
    packed = store.get(scans)
    images = (unpack(packed, number) for number in range(len(packed["owner"])))
    shown = frontals(images, segment, register, frontal, turns_deg)
    return {"owner": packed["owner"], **shown}


def noisy_crops(
    store: Store,
    *,
    scans: Cell,
    frontal: Step,
    register: Step,
    sigma_mm: float,
    denoise: Step,
    seed: tuple[int, ...],
    turns_deg: tuple[float, ...] = (),
    segment: Step = SLICES,
) -> Arrays:
    """Frontal images of scans that were given Gaussian noise, then denoised; as `crops`."""
    packed = store.get(scans)
    images = map(denoise, noisy(packed, sigma_mm, seed))
    shown = frontals(images, segment, register, frontal, turns_deg)
    return {"owner": packed["owner"], **shown}


def noisy(packed: Arrays, sigma_mm: float, seed: tuple[int, ...]) -> Iterator[RangeImage]:
    """Packed scans with Gaussian noise on every pixel, always the same."""
    for number in range(len(packed["owner"])):
        rng = np.random.default_rng([*seed, number, 0x015E])
        yield add_noise(unpack(packed, number), sigma_mm, rng=rng)


def frontals(
    images: Iterable[RangeImage],
    segment: Step,
    register: Step,
    frontal: Step,
    turns_deg: tuple[float, ...] = (),
) -> dict[str, NDArray[Any]]:
    """Find the face of each image, register, turn and resample it.

    Returns
    -------
    dict
        "depth", "sigma", "pitch_mm" and "stage" as `crops` gives them.
    """
    params = frontal.all_params()
    empty = np.full((1 + 3 * len(turns_deg), params["height"], params["width"]), np.nan, np.float32)
    depth, sigma, stage = [], [], []
    for image in images:
        faces = segment(image)
        alignment = register(faces[0]) if faces else None
        done = alignment is not None and alignment.converged
        stage.append(NO_FACE if not faces else ACQUIRED if done else NOT_REGISTERED)
        turned = _turned(alignment, turns_deg) if alignment is not None and done else ()
        views = [frontal(faces[0], one) for one in turned]
        depth.append(np.stack([v.depth for v in views]) if views else empty)
        sigma.append(np.stack([_sigma(v) for v in views]) if views else empty)
    return {
        "depth": np.stack(depth),
        "sigma": np.stack(sigma),
        "pitch_mm": np.array(params["width_mm"] / params["width"]),
        "stage": np.array(stage),
    }


def _turned(alignment: Alignment, turns_deg: tuple[float, ...]) -> Iterator[Alignment]:
    """The alignment itself, then rotated by every angle about every axis."""
    yield alignment
    for axis, angle in product(np.eye(3), turns_deg):
        turn = RigidTransform(rotation_matrix(np.deg2rad(angle) * axis), np.zeros(3), source="face")
        yield Alignment(turn @ alignment.transform)


def _sigma(image: RangeImage) -> Float32:
    # where nothing is known of the noise, every pixel counts alike
    return np.ones(image.shape, np.float32) if image.sigma is None else image.sigma


def spoiled(
    store: Store, *, crops: Cell, sigma_mm: float, denoise: Step, seed: tuple[int, ...]
) -> Arrays:
    """Crops with Gaussian noise on every pixel, denoised: nothing smooths after the noise."""
    clean = store.get(crops)
    depth, sigma = clean["depth"].copy(), clean["sigma"].copy()
    for row in np.flatnonzero(clean["stage"] == ACQUIRED).tolist():
        for k in range(depth.shape[1]):
            rng = np.random.default_rng([*seed, row, k, 0xC409])
            image = image_of(clean, row, k)
            image = image.with_depth(image.depth, sigma=np.full(image.shape, 1e-3))
            image = denoise(add_noise(image, sigma_mm, rng=rng))
            depth[row, k] = image.depth
            sigma[row, k] = _sigma(image)
    return {**clean, "depth": depth, "sigma": sigma}


def image_of(arrays: Arrays, row: int, view: int = 0) -> RangeImage:
    """One frontal image of crops."""
    depth = arrays["depth"][row, view]
    height, width = depth.shape
    camera = Orthographic(
        float(arrays["pitch_mm"]), (width - 1) / 2, (height - 1) / 2, width, height
    )
    return RangeImage(depth, camera, sigma=arrays["sigma"][row, view])


# ── recognition ──────────────────────────────────────────────────────────────────────────


def features(store: Store, *, crops: Cell, feature: Step) -> Arrays:
    """Feature vectors (n, k, D) of crops, NaN for a view that shows nothing."""
    arrays = store.get(crops)
    shown = np.isfinite(arrays["depth"]).any(axis=(2, 3))
    rows = [np.ravel(feature(image_of(arrays, row, k))) for row, k in np.argwhere(shown).tolist()]
    X = np.full((*shown.shape, len(rows[0]) if rows else 1), np.nan, np.float32)
    if rows:
        X[shown] = rows
    return {"X": X, "owner": arrays["owner"]}


@kept
def recognition(
    store: Store,
    *,
    training: tuple[Cell, ...],
    probes: Cell,
    feature: Step,
    classifier: Step,
) -> Arrays:
    """Learn from some crops, compare others.

    Returns
    -------
    dict
        "scores" (n, k, people) float32: every view of every probe against each person's best
        view, NaN where a view shows nothing; "owner" (n,).
    """
    model, G, people = _model(store, training, feature, classifier)
    taken = store.get(cell(features, crops=probes, feature=feature))
    X, owner = taken["X"], taken["owner"]
    count = 1 + max(int(people.max()), int(owner.max()))
    scores = np.full((*X.shape[:2], count), np.nan, np.float32)
    shown = np.isfinite(X[..., 0])
    if shown.any():
        alike = model.similarity(model.transform(X[shown]), G)
        best = np.full((len(alike), count), np.nan, np.float32)
        for person in np.unique(people):
            best[:, person] = alike[:, people == person].max(axis=1)
        scores[shown] = best
    return {"scores": scores, "owner": owner}


@lru_cache(maxsize=16)
def _model(
    store: Store, training: tuple[Cell, ...], feature: Step, classifier: Step
) -> tuple[Any, Float32, NDArray[np.intp]]:
    """The fitted classifier, the transformed training views, and whose they are."""
    taken = [store.get(cell(features, crops=crops, feature=feature)) for crops in training]
    X = np.concatenate([t["X"].reshape(-1, t["X"].shape[2]) for t in taken])
    owner = np.concatenate([np.repeat(t["owner"], t["X"].shape[1]) for t in taken])
    shown = np.isfinite(X[:, 0])
    model = classifier().fit(X[shown], owner[shown])
    return model, model.transform(X[shown]), owner[shown]
