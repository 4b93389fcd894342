"""ICP, then the face's own symmetry: a turned face comes back, whoever it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface import register, simulate
from rangeface.numerics.midline import Midline, midline, most_protruding
from rangeface.numerics.se3 import head_rotation, rotation_angle
from rangeface.types import Alignment, Face, Pinhole, PointSet, RangeImage, RigidTransform

CAMERA = Pinhole(230.0, 230.0, 87.5, 71.5, 176, 144)
POSES = [(0.0, 0.0, 0.0), (28.0, 5.0, -8.0), (-42.0, -5.0, 6.0), (3.0, 25.0, 0.0)]


def _pose(yaw: float, pitch: float, roll: float) -> RigidTransform:
    return simulate.pose(
        yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll, nose_tip_mm=(5.0, -4.0, 420.0)
    )


def _face(head: simulate.Head, pose: RigidTransform, noise_mm: float = 1.0) -> Face:
    image = simulate.render(head, CAMERA, pose).image
    image = simulate.add_noise(image, noise_mm, rng=np.random.default_rng(1))
    turn = head_rotation(*np.deg2rad([7.0, -4.0, 5.0]))
    moved = pose.translation + np.array([4.0, -5.0, 3.0])
    start = RigidTransform(turn @ pose.rotation, moved, "camera", "face").inverse()
    return Face(image, moved, pose=start)


def _plane_error_deg(alignment: Alignment, pose: RigidTransform) -> float:
    cosine = abs(float(alignment.transform.rotation[0] @ pose.rotation[:, 0]))
    return float(np.rad2deg(np.arccos(min(cosine, 1.0))))


def _wide(head: simulate.Head) -> simulate.Head:
    """The head of nobody in the reference's population: flat and wide."""
    stretched = head.surface.points * np.array([1.12, 0.94, 0.9], np.float32)
    return replace(head, surface=PointSet(stretched, head.surface.triangles))


@pytest.mark.parametrize("person", range(3))
@pytest.mark.parametrize("angles", POSES)
def test_a_turned_head_comes_back(person: int, angles: tuple) -> None:
    pose = _pose(*angles)
    alignment = register.symmetric(_face(simulate.head(person), pose))
    assert alignment.converged
    assert _plane_error_deg(alignment, pose) < 3.0
    assert np.linalg.norm(alignment.transform.inverse().translation - pose.translation) < 8.0


@pytest.mark.parametrize("angles", POSES)
def test_a_head_unlike_the_reference_comes_back_too(angles: tuple) -> None:
    pose = _pose(*angles)
    alignment = register.symmetric(_face(_wide(simulate.head(4)), pose))
    assert alignment.converged
    assert _plane_error_deg(alignment, pose) < 3.0
    assert np.linalg.norm(alignment.transform.inverse().translation - pose.translation) < 10.0


def test_two_scans_of_a_person_are_turned_into_one_frame() -> None:
    head = _wide(simulate.head(5))
    poses = [_pose(yaw, 0.0, 0.0) for yaw in (0.0, -30.0, 30.0, 45.0)]
    frames = [register.symmetric(_face(head, p)).transform.rotation @ p.rotation for p in poses]
    for other in frames[1:]:
        assert np.rad2deg(rotation_angle(other @ frames[0].T)) < 5.0


def test_the_plane_is_better_than_that_of_icp_alone() -> None:
    errors: dict[str, list[float]] = {"icp": [], "symmetric": []}
    for person in range(4):
        pose = _pose(-40.0, 0.0, 0.0)
        face = _face(_wide(simulate.head(person)), pose, 0.3)
        for name, found in errors.items():
            found.append(_plane_error_deg(register.METHODS[name](face), pose))
    assert np.mean(errors["symmetric"]) < 0.7 * np.mean(errors["icp"])


def test_a_plane_that_disagrees_leaves_the_pose_to_icp() -> None:
    face = _face(simulate.head(1), _pose(20.0, 0.0, 0.0))
    by_icp = register.icp(face)
    kept = register.symmetric(face, max_change_deg=0.0)
    assert kept.converged
    assert np.array_equal(kept.transform.rotation, by_icp.transform.rotation)
    assert np.array_equal(kept.transform.translation, by_icp.transform.translation)


def test_half_a_face_keeps_the_pose_of_icp() -> None:
    face = _face(simulate.head(2), _pose(0.0, 0.0, 0.0))
    columns = np.arange(CAMERA.width)
    half = replace(face, image=face.image.masked(np.tile(columns > 84, (CAMERA.height, 1))))
    by_icp, found = register.icp(half), register.symmetric(half)
    assert found.converged == by_icp.converged
    turned = rotation_angle(found.transform.rotation @ by_icp.transform.rotation.T)
    assert np.rad2deg(turned) < 10.0


def test_the_same_face_is_registered_alike_twice_and_is_left_as_it_was() -> None:
    image, pose = sr3000_face(yaw=15.0)
    face = Face(image, pose.translation, pose=pose.inverse())
    first, second = register.symmetric(face), register.symmetric(face)
    assert np.array_equal(first.transform.rotation, second.transform.rotation)
    assert first.correlation == second.correlation > 0.4


def _ridge(noise_mm: float, tip_y: float) -> RangeImage:
    v, u = np.indices((144, 176))
    x, y = (u - 87.5) * 400 / 230, (v - 71.5) * 400 / 230
    depth = 400.0 + 0.05 * x**2 + 0.02 * (y - tip_y) ** 2
    noise = noise_mm * np.random.default_rng(0).standard_normal(depth.shape)
    return RangeImage(depth + noise, CAMERA)


@pytest.mark.parametrize("tip_y", [-12.0, 0.0, 9.0])
@pytest.mark.parametrize("noise_mm", [0.0, 1.5])
def test_the_tip_of_a_ridge_is_found_through_noise(tip_y: float, noise_mm: float) -> None:
    image = _ridge(noise_mm, tip_y)
    profile = midline(
        image.points, np.ones(image.shape, np.float32), np.eye(3), np.array([0.0, 0.0, -400.0]),
        half_width_mm=5.0, reach_mm=35.0, smooth_mm=2.0,
    )  # fmt: skip
    tip = most_protruding(profile, within_mm=25.0)
    assert tip is not None
    assert tip[0] == pytest.approx(tip_y, abs=0.5 if noise_mm == 0.0 else 3.0)
    assert tip[1] == pytest.approx(0.0, abs=0.6)


def test_a_slope_has_no_tip_and_an_empty_profile_none() -> None:
    y = np.arange(-30.0, 31.0)
    assert most_protruding(Midline(y, 0.5 * y), within_mm=25.0) is None
    assert most_protruding(Midline(y, np.full_like(y, np.nan)), within_mm=25.0) is None


def test_what_is_not_seen_of_a_profile_is_nan() -> None:
    image = _ridge(0.0, 0.0).masked(np.indices((144, 176))[0] < 72)
    profile = midline(
        image.points, np.ones(image.shape, np.float32), np.eye(3), np.array([0.0, 0.0, -400.0]),
        half_width_mm=5.0, reach_mm=35.0, smooth_mm=1.0,
    )  # fmt: skip
    assert np.isnan(profile.z[profile.y > 6.0]).all()
    assert np.isfinite(profile.z[(profile.y < 0.0) & (profile.y > -30.0)]).all()
    nothing = image.masked(np.zeros(image.shape, bool))
    profile = midline(
        nothing.points, np.ones(image.shape, np.float32), np.eye(3), np.zeros(3),
        half_width_mm=5.0, reach_mm=35.0, smooth_mm=1.0,
    )  # fmt: skip
    assert np.isnan(profile.z).all()
