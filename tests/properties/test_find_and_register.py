"""Faces of known pose are found, registered and resampled; what is no face is refused."""

from __future__ import annotations

import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface import register, segment, simulate
from rangeface.errors import NoFaceError
from rangeface.numerics.se3 import rotation_angle
from rangeface.types import Face, Pinhole, RangeImage, Reason

CAMERA = Pinhole(230.0, 230.0, 87.5, 71.5, 176, 144)
POSES = [(0.0, 0.0), (25.0, 0.0), (-25.0, 5.0), (0.0, 20.0), (0.0, -20.0)]


@pytest.mark.parametrize(("yaw", "pitch"), POSES)
def test_nose_tip_and_pose_of_a_simulated_capture(yaw: float, pitch: float) -> None:
    image, pose = sr3000_face(yaw=yaw, pitch=pitch)
    faces = segment.slices(image)
    assert len(faces) == 1
    assert np.linalg.norm(faces[0].nose_tip - pose.translation) < 10.0
    alignment = register.icp(faces[0])
    assert alignment.converged
    turn = alignment.transform.rotation @ pose.rotation
    assert np.rad2deg(rotation_angle(turn)) < 6.0


def test_two_people_in_one_image_are_two_faces() -> None:
    camera = Pinhole(230.0, 230.0, 159.5, 119.5, 320, 240)
    heads = [simulate.head(1), simulate.head(2)]
    poses = [simulate.pose(nose_tip_mm=(x, 0.0, z)) for x, z in ((-140.0, 520.0), (150.0, 600.0))]
    faces = segment.slices(simulate.render(heads, camera, poses).image)
    tips = sorted(face.nose_tip[0] for face in faces)
    assert len(tips) == 2
    assert np.allclose(tips, [-140.0, 150.0], atol=10.0)


def test_the_crop_is_the_sphere() -> None:
    image, _ = sr3000_face()
    face = segment.slices(image, radius_mm=100.0)[0]
    distance = np.linalg.norm(face.image.points - face.nose_tip, axis=-1)
    assert np.nanmax(distance) <= 100.0 + 1e-3


def _depth_image(depth: np.ndarray) -> RangeImage:
    return RangeImage(depth, CAMERA)


def _ball(radius: float) -> np.ndarray:
    v, u = np.indices((144, 176))
    x, y = (u - 87.5) * 400 / 230, (v - 71.5) * 400 / 230
    inside = radius**2 - x**2 - y**2
    return np.where(inside > 0, 400 + radius - np.sqrt(np.maximum(inside, 0)), np.nan)


NO_FACES = {
    "wall": np.full((144, 176), 500.0),
    "slanted wall": 500.0 + 2.0 * np.indices((144, 176))[1],
    "ball": _ball(90.0),
    "noise": 500.0 + 40.0 * np.random.default_rng(0).standard_normal((144, 176)),
}


@pytest.mark.parametrize("name", NO_FACES)
def test_what_is_no_face_is_not_found_and_the_reason_is_given(name: str) -> None:
    faces = segment.slices(_depth_image(NO_FACES[name]))
    assert len(faces) == 0
    assert faces.reason is Reason.NO_FACE


def test_an_image_without_valid_pixels_says_so() -> None:
    faces = segment.slices(_depth_image(np.full((144, 176), np.nan)))
    assert faces.reason is Reason.NO_VALID_PIXELS


DEGENERATE = {
    "plane": np.full((144, 176), 400.0),
    "ball": _ball(90.0),
    "twenty points": np.where(np.random.default_rng(1).random((144, 176)) < 8e-4, 400.0, np.nan),
    "nothing": np.full((144, 176), np.nan),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_registration_refuses_what_does_not_determine_a_pose(name: str) -> None:
    face = Face(_depth_image(DEGENERATE[name]), nose_tip=[0.0, 0.0, 400.0])
    alignment = register.icp(face)
    assert not alignment.converged
    assert alignment.reason is not None
    with pytest.raises(NoFaceError, match="refused"):
        register.frontal.resample(face, alignment)


def test_frontal_images_of_one_person_agree_whatever_the_pose() -> None:
    frontals = []
    for yaw in (0.0, 12.0):
        image, _ = sr3000_face(yaw=yaw)
        face = segment.slices(image)[0]
        frontals.append(register.frontal.resample(face, register.icp(face)))
    first, second = frontals
    both = ~first.filled & ~second.filled
    assert np.median(np.abs(first.depth - second.depth)[both]) < 3.0
    assert first.mask.all()
    assert abs(first.depth[38:42, 23:27].mean()) < 5.0


def test_sigma_and_amplitude_travel_to_the_frontal_image() -> None:
    image, _ = sr3000_face()
    face = segment.slices(image)[0]
    frontal = register.frontal.resample(face, register.icp(face))
    assert frontal.amplitude is not None
    assert 0.5 < np.nanmedian(frontal.sigma) < np.nanmedian(image.sigma)


def test_an_unregistered_crop_is_only_moved() -> None:
    image, _ = sr3000_face(yaw=25.0)
    face = segment.slices(image)[0]
    alignment = register.none(face)
    assert np.array_equal(alignment.transform.rotation, np.eye(3))
    assert np.allclose(alignment.transform.apply(face.nose_tip), 0.0)
