"""Is anything that is no face ever accepted? Walls, hands, balls, half faces, noise, nothing.

People are simulated and enrolled with the model that ships; then it looks at scenes without a
whole face. Every refusal must give its reason.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rangeface import sensors, simulate
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments import models
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.sources import Source, head_of
from rangeface.evaluation.experiments.visits import (
    DISTANCE_MM,
    ENROLMENT,
    SENSOR,
    made,
    templates_of,
)
from rangeface.evaluation.findings import Findings, Table
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.gallery import MemoryGallery
from rangeface.numerics.se3 import rotation_matrix
from rangeface.pipeline import Step, step
from rangeface.types import Pinhole, PointSet, RangeImage, RigidTransform, Verdict

#: Scenes of each kind for each person enrolled, and in a cell.
SCENES, CHUNK = 25, 125
FMR = 0.001
ACCEPTED = "accepted"
TITLE = "Things that are no faces"


# ── cells ────────────────────────────────────────────────────────────────────────────────


@kept
def answers(
    store: Store,
    *,
    model: str,
    enrolled: tuple[Cell, ...],
    scene: Step,
    seed: int,
    first: int,
    count: int,
    fmr: float = FMR,
) -> Arrays:
    """What is said to scenes of one kind.

    Returns
    -------
    dict
        "answer" (count,) str: `ACCEPTED`, or the reason why not.
    """
    asked, gallery = models.recognizer(model), MemoryGallery()
    for k, template in enumerate(made(store, enrolled, asked.pipeline.fingerprint)):
        if template is not None:
            gallery.enroll(str(k), template)
    said = []
    for number in range(first, first + count):
        rng = np.random.default_rng([seed, number, *scene.name.encode()])
        decision = asked.identify(scene(rng), gallery, fmr=fmr)
        said.append(ACCEPTED if decision.verdict is Verdict.ACCEPTED else str(decision.reason))
    return {"answer": np.array(said)}


def cells(source: Source) -> list[Cell]:
    """A cell a kind and chunk of scenes."""
    source.need_heads("non_faces")
    return [one for scene in kinds(source).values() for one in shown(source, scene)]


def shown(source: Source, scene: Step) -> list[Cell]:
    """The cells of one kind of scene."""
    first, count = models.newcomers(source), SCENES * source.persons
    enrolled = templates_of(source, ENROLMENT, range(first, first + source.persons))
    return [
        cell(
            answers, model=models.shipped(), enrolled=enrolled, scene=scene, seed=source.seed,
            first=start, count=min(CHUNK, count - start),
        )
        for start in range(0, count, CHUNK)
    ]  # fmt: skip


# ── what comes of it ─────────────────────────────────────────────────────────────────────


def tabulate(source: Source, results: Results) -> Findings:
    """How many of each kind were accepted, and why the others were not."""
    rows, said = [], Counter[str]()
    for kind, scene in kinds(source).items():
        answer = np.concatenate([results(one)["answer"] for one in shown(source, scene)])
        found = Counter(answer.tolist())
        rows.append(_row(kind, found))
        said += found
    rows.append(_row("all", said))
    caption = f"Scenes accepted [95 %] (counts) at an FMR of {100 * FMR:g} %, and reasons given"
    return Findings(
        TITLE, "Is anything that is no face ever accepted, and does every refusal say why?",
        readings=[
            f"Accepted non-faces: {said[ACCEPTED] or 'none'} of {said.total()}.",
            f"{source.persons} people enrolled; simulated SR-3000; the model that ships.",
        ],
        tables=[Table("non_faces", caption, ["kind", ACCEPTED, "reasons given"], rows)],
    )  # fmt: skip


def _row(kind: str, said: Counter[str]) -> list[str]:
    reasons = [f"{reason} {n}" for reason, n in said.most_common() if reason != ACCEPTED]
    return [kind, str(Rate.of(said[ACCEPTED], said.total())), ", ".join(reasons)]


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


def half_face(rng: np.random.Generator, *, source: Source) -> RangeImage:
    """A stranger's face behind a straight edge: one side, above or below the nose is hidden."""
    person = models.newcomers(source) + int(rng.integers(50_000, 60_000))
    pose = simulate.pose(
        yaw_deg=rng.uniform(-15, 15), pitch_deg=rng.uniform(-10, 10),
        nose_tip_mm=(*rng.uniform(-20, 20, 2), DISTANCE_MM),
    )  # fmt: skip
    head = head_of(source, person, expression="neutral", session=0)
    image = _seen([head], rng, [pose])
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


def kinds(source: Source) -> dict[str, Step]:
    """What is shown; half faces are of the source's people."""
    return {
        "walls": step(wall),
        "balls": step(ball),
        "hands": step(hand),
        "half faces": step(half_face, source=source),
        "noise": step(noise),
        "all invalid": step(nothing),
    }


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=20, minutes=3.0)
