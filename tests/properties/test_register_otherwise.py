"""The symmetry plane, landmarks and the k-d tree: other ways to a frontal face."""

from __future__ import annotations

import numpy as np
import pytest

from rangeface import register, simulate
from rangeface.numerics.se3 import head_rotation, rotation_angle
from rangeface.types import Face, Pinhole, PointSet, RangeImage, RigidTransform

CAMERA = Pinhole(230.0, 230.0, 87.5, 71.5, 176, 144)
POSES = [(0.0, 0.0, 0.0), (20.0, 5.0, -8.0), (-25.0, -10.0, 6.0)]


def _scan(person: int, pose: RigidTransform) -> RangeImage:
    image = simulate.render(simulate.head(person), CAMERA, pose).image
    return simulate.add_noise(image, 1.0, rng=np.random.default_rng(person))


def _pose(yaw: float, pitch: float, roll: float) -> RigidTransform:
    return simulate.pose(
        yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll, nose_tip_mm=(5.0, -4.0, 420.0)
    )


def _wrong(pose: RigidTransform) -> RigidTransform:
    """A start T_face_camera, some degrees and millimetres off."""
    turn = head_rotation(*np.deg2rad([7.0, -4.0, 5.0]))
    moved = pose.translation + np.array([4.0, -5.0, 3.0])
    return RigidTransform(turn @ pose.rotation, moved, "camera", "face").inverse()


@pytest.mark.parametrize("person", range(3))
@pytest.mark.parametrize("angles", POSES)
def test_the_symmetry_plane_of_a_head_is_found(person: int, angles: tuple) -> None:
    pose = _pose(*angles)
    face = Face(_scan(person, pose), pose.translation, pose=_wrong(pose))
    alignment = register.mirror(face)
    assert alignment.converged
    cosine = abs(alignment.transform.rotation[0] @ pose.rotation[:, 0])
    assert np.rad2deg(np.arccos(min(cosine, 1.0))) < 3.0
    assert np.linalg.norm(alignment.transform.inverse().translation - pose.translation) < 8.0


@pytest.mark.parametrize("angles", POSES)
def test_a_cloud_without_order_is_registered_as_an_image_is(angles: tuple) -> None:
    pose = _pose(*angles)
    image = _scan(1, pose)
    shuffled = np.random.default_rng(0).permutation(image.points[image.mask])
    by_tree = register.cloud(PointSet(shuffled), _wrong(pose))
    by_pixel = register.icp(Face(image, pose.translation, pose=_wrong(pose)))
    assert by_tree.converged
    turn = by_tree.transform.rotation @ by_pixel.transform.rotation.T
    assert np.rad2deg(rotation_angle(turn)) < 3.0


@pytest.mark.parametrize("angles", POSES)
def test_true_landmarks_give_the_pose_of_the_mean_head(angles: tuple) -> None:
    pose = _pose(*angles)
    marks = {name: pose.apply(p) for name, p in simulate.mean_head().landmarks.items()}
    face = Face(_scan(1, pose), pose.translation, landmarks=marks)
    alignment = register.landmarks(face)
    assert alignment.converged
    assert alignment.rms_mm < 0.1
    assert np.allclose(alignment.transform.rotation, pose.rotation.T, atol=1e-3)
