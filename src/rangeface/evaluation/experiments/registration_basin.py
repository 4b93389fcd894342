"""How far from frontal is a face still found and registered, and how often is none taken for one?

Heads of known pose, clean and as an SR-3000 sees them: where the finder and where registration
put the nose tip, whether two scans of one person are registered alike, how well the mirror finds
the symmetry plane; from which start angles ICP arrives; and how many faces are found in scenes
without one.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rangeface import register, segment, sensors, simulate
from rangeface.evaluation.experiments.face_free import KINDS, scene
from rangeface.numerics.se3 import head_rotation, rotation_angle
from rangeface.numerics.statistics import wilson
from rangeface.types import Alignment, Face, Float64, RangeImage, RigidTransform

NOSE_MM, PAIR_DEG, PLANE_DEG = 10.0, 5.0, 3.0
#: Name → expression, yaw, pitch (degrees); the source paper's directions, and wider ones.
POSES: dict[str, tuple[str, float, float]] = {
    "frontal": ("neutral", 0.0, 0.0),
    "smile": ("smile", 0.0, 0.0),
    "laugh": ("laugh", 0.0, 0.0),
    "up": ("neutral", 0.0, -35.0),
    "down": ("neutral", 0.0, 35.0),
    "left": ("neutral", -35.0, 0.0),
    "right": ("neutral", 35.0, 0.0),
    "left 15": ("neutral", -15.0, 0.0),
    "right 30": ("neutral", 30.0, 0.0),
    "left 45": ("neutral", -45.0, 0.0),
}
#: How the scans are registered.
REGISTERED = ("icp", "symmetric")
START_ANGLES = tuple(range(-60, 61, 10))


class Scan(NamedTuple):
    """A scan, the true pose T_camera_face, and what was made of it; alignments by method."""

    image: RangeImage
    pose: RigidTransform
    face: Face | None
    alignments: Mapping[str, Alignment]


def run(
    *,
    seed: int = 0,
    ict: str | Path | None = None,
    people: int = 25,
    face_free: int = 2000,
    basin_people: int = 6,
) -> dict[str, Any]:
    """Measure finding and registration on simulated scans of known pose.

    Parameters
    ----------
    seed : int
        First person; people, noise and scenes follow from it.
    ict : str or Path, optional
        A user's copy of ICT-FaceKit, as for `simulate.ict_facekit`: a second population.
    people : int
        People of each population; each is scanned in every pose, clean and noisy.
    face_free : int
        Scenes without a face.
    basin_people : int
        People whose scans are registered from every start angle.

    Returns
    -------
    dict
        Rates as [k, n, low, high] (95 % Wilson), by population, noise and pose.
    """
    populations: dict[str, Callable[..., simulate.Head]] = {"own": simulate.head}
    if ict is not None:
        populations["ict"] = simulate.ict_facekit(ict).head
    result: dict[str, Any] = {"people": people, "poses": {}}
    for name, population in populations.items():
        for noise in ("clean", "sr3000"):
            scans = [
                {pose: _scan(population, person, pose, noise) for pose in POSES}
                for person in range(seed + 1, seed + 1 + people)
            ]
            result["poses"][f"{name}, {noise}"] = _rates(scans)
    result["basin"] = basin(range(seed + 1, seed + 1 + basin_people))
    result["face_free"] = false_faces(face_free, seed)
    return result


# ── scans of known pose ──────────────────────────────────────────────────────────────────


def _scan(population: Callable[..., simulate.Head], person: int, name: str, noise: str) -> Scan:
    expression, yaw, pitch = POSES[name]
    rng = np.random.default_rng([person, *name.encode()])
    jitter = rng.uniform(-3.0, 3.0, 3)
    pose = simulate.pose(
        yaw_deg=yaw + jitter[0], pitch_deg=pitch + jitter[1], roll_deg=jitter[2],
        nose_tip_mm=(float(rng.uniform(-15, 15)), float(rng.uniform(-15, 15)), 420.0),
    )  # fmt: skip
    sensor = _sensor()
    view = simulate.render(population(person, expression=expression), sensor.camera, pose)
    image = view.image if noise == "clean" else simulate.tof(view, sensor, rng=rng)
    faces = segment.slices(image)
    face = faces[0] if faces else None
    alignments = {} if face is None else {m: register.METHODS[m](face) for m in REGISTERED}
    return Scan(image, pose, face, alignments)


def _sensor() -> sensors.SensorModel:
    """A calibrated SR-3000: random noise only."""
    systematic = ("wiggling", "multipath", "scattering", "fixed pattern", "compression")
    return sensors.preset("sr3000").without(*systematic)


def _rates(people: list[dict[str, Scan]]) -> dict[str, Any]:
    turned = [pose for pose in POSES if pose != "frontal"]
    tables: dict[str, dict[str, list[bool]]] = {
        "nose": {pose: [_nose_found(scans[pose]) for scans in people] for pose in POSES},
        "nose, registered": {
            pose: [_nose_registered(scans[pose]) for scans in people] for pose in POSES
        },
    }
    for method in REGISTERED:
        tables[f"pair, {method}"] = {
            pose: [_alike(scans["frontal"], scans[pose], method) for scans in people]
            for pose in turned
        }
    tables["plane"] = {
        pose: [_plane_found(scans[pose]) for scans in people]
        for pose in ("frontal", "smile", "laugh", "left 15", "right 30")
    }
    return {
        kind: {pose: _rate(sum(good), len(good)) for pose, good in table.items()}
        for kind, table in tables.items()
    }


def _rate(successes: int, n: int) -> list[float]:
    """[k, n, low, high] of a proportion."""
    low, high = wilson(successes, n) if n else (0.0, 1.0)
    return [successes, n, round(float(low), 5), round(float(high), 5)]


def _nose_found(scan: Scan) -> bool:
    if scan.face is None:
        return False
    return bool(np.linalg.norm(scan.face.nose_tip - scan.pose.translation) <= NOSE_MM)


def _nose_registered(scan: Scan) -> bool:
    """Whether the origin of the registered face's frame is the nose tip."""
    alignment = scan.alignments.get("symmetric")
    if alignment is None or not alignment.converged:
        return False
    origin = alignment.transform.inverse().translation
    return bool(np.linalg.norm(origin - scan.pose.translation) <= NOSE_MM)


def _alike(one: Scan, other: Scan, method: str) -> bool:
    """Whether two scans of a person are turned into the same frame."""
    errors = []
    for scan in (one, other):
        alignment = scan.alignments.get(method)
        if alignment is None or not alignment.converged:
            return False
        errors.append(alignment.transform.rotation @ scan.pose.rotation)
    return bool(np.rad2deg(rotation_angle(errors[0] @ errors[1].T)) <= PAIR_DEG)


def _plane_found(scan: Scan) -> bool:
    if scan.face is None:
        return False
    alignment = register.mirror(scan.face)
    cosine = abs(float(alignment.transform.rotation[0] @ scan.pose.rotation[:, 0]))
    return bool(alignment.converged and np.rad2deg(np.arccos(min(cosine, 1.0))) <= PLANE_DEG)


# ── the basin of ICP ─────────────────────────────────────────────────────────────────────


def basin(people: range) -> dict[str, Any]:
    """Success of ICP within 5° against the start's error in yaw and pitch: (pitch, yaw) rates.

    With all the starts that `register.icp` tries where its first attempt is refused.
    """
    success = np.zeros((len(START_ANGLES), len(START_ANGLES)))
    for person in people:
        scan = _scan(simulate.head, person, "frontal", "sr3000")
        for i, pitch in enumerate(START_ANGLES):
            for j, yaw in enumerate(START_ANGLES):
                success[i, j] += _arrives(scan, np.deg2rad(yaw), np.deg2rad(pitch))
    return {
        "angles_deg": list(START_ANGLES),
        "success": (success / max(len(people), 1)).round(3).tolist(),
    }


def _arrives(scan: Scan, yaw: float, pitch: float) -> bool:
    turned: Float64 = scan.pose.rotation @ head_rotation(yaw, pitch, 0.0)
    start = RigidTransform(turned, scan.pose.translation, target="camera", source="face")
    alignment = register.icp(Face(scan.image, scan.pose.translation, pose=start.inverse()))
    error = rotation_angle(alignment.transform.rotation @ scan.pose.rotation)
    return alignment.converged and np.rad2deg(error) <= PAIR_DEG


# ── scenes without a face ────────────────────────────────────────────────────────────────


def false_faces(count: int, seed: int) -> dict[str, Any]:
    """Scenes of each kind, and in how many of them a face is found."""
    sensor, kinds = _sensor(), list(KINDS)
    scenes, found = dict.fromkeys(kinds, 0), dict.fromkeys(kinds, 0)
    for k in range(count):
        kind = kinds[k % len(kinds)]
        rng = np.random.default_rng([seed, k, 0xFACE])
        view = scene(kind, 1_000_000 * (seed + 1) + k, sensor.camera)
        image = view.image if rng.random() < 0.5 else simulate.tof(view, sensor, rng=rng)
        scenes[kind] += 1
        found[kind] += int(bool(segment.slices(image)))
    return {"scenes": scenes, "found": found, "all": _rate(sum(found.values()), count)}


# ── picture and command line ─────────────────────────────────────────────────────────────


def draw(result: dict[str, Any], path: Path) -> None:
    """Picture of success against the start's yaw and pitch."""
    from matplotlib.figure import Figure

    angles, success = result["basin"]["angles_deg"], np.array(result["basin"]["success"])
    figure = Figure(figsize=(5.2, 4.4), layout="constrained")
    axes = figure.add_subplot()
    edge = (angles[0] - 5, angles[-1] + 5)
    shown = axes.imshow(
        100 * success, extent=(*edge, *edge), origin="lower", cmap="viridis", vmin=0, vmax=100
    )
    axes.set(xlabel="start wrong in yaw, degrees", ylabel="start wrong in pitch, degrees")
    figure.colorbar(shown, label="registered within 5°, % of scans")
    figure.savefig(path, dpi=120)


def main() -> None:
    """Run from the command line: writes registration_basin.json and registration_basin.png."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", type=int, default=25)
    parser.add_argument("--basin-people", type=int, default=6)
    parser.add_argument("--face-free", type=int, default=2000)
    parser.add_argument("--ict", type=Path, default=None)
    parser.add_argument("--out", type=Path, default=Path())
    arguments = parser.parse_args()
    result = run(
        people=arguments.people,
        face_free=arguments.face_free,
        ict=arguments.ict,
        basin_people=arguments.basin_people,
    )
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "registration_basin.json").write_text(json.dumps(result, indent=1))
    draw(result, arguments.out / "registration_basin.png")
    print(json.dumps({k: v for k, v in result.items() if k != "basin"}, indent=1))


if __name__ == "__main__":
    main()
