"""Is anything that is no face ever accepted? Walls, hands, balls, half faces, noise, nothing.

People are simulated and enrolled with the model that is asked; then it looks at scenes without
a whole face. Every refusal must give its reason.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from rangeface import sensors, simulate
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.synthetic import GALLERY, capture
from rangeface.gallery import MemoryGallery
from rangeface.numerics.se3 import rotation_matrix
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Pinhole, PointSet, RangeImage, RigidTransform, Verdict

SENSOR, DISTANCE_MM = "sr3000", 400.0
#: People of the experiment are numbered from here: no model has met them.
FIRST_PERSON = 3_000_000

Make: TypeAlias = Callable[[np.random.Generator], RangeImage]


def run(
    *, recognizer: FaceRecognizer, seed: int = 0, count: int = 3000, enrolled: int = 20,
    fmr: float = 0.001,
) -> dict[str, Any]:  # fmt: skip
    """Show non-faces to a recogniser with people enrolled.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Calibrated.
    seed : int
    count : int
        Scenes, shared among the kinds.
    enrolled : int
        People in the gallery.
    fmr : float
        Accepted false match rate of one comparison.

    Returns
    -------
    dict
        For each kind: scenes, accepted with its interval, and how often each reason was given.
    """
    gallery, people = MemoryGallery(), range(FIRST_PERSON, FIRST_PERSON + enrolled)
    for person in people:
        frames = capture(Path(f"{person}"), person=person, visit=GALLERY, sensor=SENSOR,
                         distance_mm=DISTANCE_MM, frames=10)  # fmt: skip
        gallery.enroll(str(person), recognizer.template(frames, augment=True))
    result: dict[str, Any] = {"enrolled": enrolled, "fmr": fmr, "seed": seed, "kinds": {}}
    total = 0
    for k, (kind, make) in enumerate(KINDS.items()):
        rng = np.random.default_rng([seed, k])
        scenes = count // len(KINDS) + (k < count % len(KINDS))
        answers: Counter[str] = Counter()
        for _ in range(scenes):
            decision = recognizer.identify(make(rng), gallery, fmr=fmr)
            accepted = decision.verdict is Verdict.ACCEPTED
            answers["accepted" if accepted else str(decision.reason)] += 1
        rate = Rate.of(answers.pop("accepted", 0), scenes)
        result["kinds"][kind] = {"accepted": str(rate), "reasons": dict(answers.most_common())}
        total += rate.count
    result["accepted"] = str(Rate.of(total, count))
    return result


# ── scenes ───────────────────────────────────────────────────────────────────────────────


def _seen(surfaces: Sequence[PointSet | simulate.Head], rng: np.random.Generator,
          poses: Sequence[RigidTransform | None] | None = None) -> RangeImage:  # fmt: skip
    sensor = sensors.preset(SENSOR)
    return simulate.tof(simulate.render(surfaces, sensor.camera, poses), sensor, rng=rng)


def _moved(mesh: PointSet, rng: np.random.Generator, turn_deg: float, depth_mm: float) -> PointSet:
    """A mesh around the origin, turned at random and put before the camera."""
    R = rotation_matrix(np.deg2rad(rng.uniform(-turn_deg, turn_deg, 3)))
    place = [*rng.uniform(-40.0, 40.0, 2), depth_mm]
    return PointSet((mesh.points @ R.T + place).astype(np.float32), mesh.triangles)


def wall(rng: np.random.Generator) -> RangeImage:
    """A wall, straight or slanted."""
    flat = simulate.wall(1.0, half_mm=2000.0)
    flat = PointSet(flat.points - np.array([0.0, 0.0, 1.0], np.float32), flat.triangles)
    return _seen([_moved(flat, rng, 35.0, rng.uniform(350.0, 1500.0))], rng)


def ball(rng: np.random.Generator) -> RangeImage:
    """Balls from a fist's to a beach ball's size, one or two; some stretched to an egg."""
    balls = []
    for _ in range(rng.integers(1, 3)):
        mesh = simulate.ball(rng.uniform(40.0, 130.0))
        egg = PointSet(mesh.points * rng.uniform(0.8, 1.3, 3).astype(np.float32), mesh.triangles)
        balls.append(_moved(egg, rng, 90.0, rng.uniform(380.0, 700.0)))
    return _seen(balls, rng)


def hand(rng: np.random.Generator) -> RangeImage:
    """An open hand or a fist: a palm and four fingers and a thumb of chained balls."""
    parts = [(np.zeros(3), np.array([42.0, 48.0, 14.0]))]
    bend = rng.uniform(-1.5, 0.3)
    for finger in range(5):
        angle = np.deg2rad((finger - 2) * 14 + rng.normal(0, 5)) if finger < 4 else 1.1
        at = np.array([(finger - 1.5) * 20.0 if finger < 4 else 45.0, -45.0, 0.0])
        for joint in range(3):
            lean = bend * joint
            step = 24.0 * np.array([np.sin(angle), -np.cos(angle) * np.cos(lean), np.sin(lean)])
            at = at + step
            parts.append((at, np.array([9.0, 14.0, 9.0])))
    meshes = [simulate.ball(1.0, rings=12) for _ in parts]
    count = len(meshes[0].points)
    points = np.concatenate(
        [m.points * size + at for m, (at, size) in zip(meshes, parts, strict=True)]
    )
    triangles = np.concatenate(
        [np.asarray(m.triangles) + k * count for k, m in enumerate(meshes)]
    ).astype(np.int32)
    whole = PointSet((points * rng.uniform(0.9, 1.4)).astype(np.float32), triangles)
    return _seen([_moved(whole, rng, 60.0, rng.uniform(350.0, 600.0))], rng)


def half_face(rng: np.random.Generator) -> RangeImage:
    """A stranger's face behind a straight edge: one side, above or below the nose is hidden."""
    person = int(rng.integers(10_000)) + FIRST_PERSON + 1_000_000
    pose = simulate.pose(
        yaw_deg=rng.uniform(-15, 15), pitch_deg=rng.uniform(-10, 10),
        nose_tip_mm=(*rng.uniform(-20, 20, 2), DISTANCE_MM),
    )  # fmt: skip
    image = _seen([simulate.head(person)], rng, [pose])
    camera = image.camera
    assert isinstance(camera, Pinhole)
    u, v = camera.project(pose.apply(np.zeros((1, 3))))[0]
    rows, cols = np.mgrid[: camera.height, : camera.width]
    side = rng.integers(4)
    margin = rng.uniform(-2.0, 4.0)
    hidden = [cols > u + margin, cols < u - margin, rows > v + margin, rows < v - margin][side]
    return image.masked(~hidden)


def noise(rng: np.random.Generator) -> RangeImage:
    """Depths without any surface, from salt to smooth hills."""
    camera = sensors.preset(SENSOR).camera
    depth = rng.normal(0.0, 1.0, (camera.height, camera.width)).astype(np.float32)
    smooth = rng.choice([0.0, 2.0, 6.0, 15.0])
    if smooth:
        from scipy.ndimage import gaussian_filter

        depth = gaussian_filter(depth, smooth)
        depth /= depth.std()
    depth = 450.0 + rng.uniform(5.0, 80.0) * depth
    seen = rng.random(depth.shape) < rng.uniform(0.3, 1.0)
    return RangeImage(np.where(seen & (depth > 50), depth, np.nan), camera,
                      sigma=np.full(depth.shape, 5.0, np.float32))  # fmt: skip


def nothing(rng: np.random.Generator) -> RangeImage:
    """No valid pixel, or a handful of them."""
    image = noise(rng)
    few = rng.random(image.shape) < rng.choice([0.0, 0.0, 1e-4, 1e-3])
    return replace(image, depth=np.where(few, image.depth, np.nan))


KINDS: dict[str, Make] = {
    "walls": wall,
    "balls": ball,
    "hands": hand,
    "half faces": half_face,
    "noise": noise,
    "all invalid": nothing,
}
