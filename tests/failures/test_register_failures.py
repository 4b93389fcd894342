"""What does not determine a pose is refused, or an error of ours: never converged and wrong."""

from __future__ import annotations

import numpy as np
import pytest

from rangeface import register, segment, simulate
from rangeface.errors import ParameterError
from rangeface.types import Face, Pinhole, PointSet, RangeImage, Reason, RigidTransform

CAMERA = Pinhole(230.0, 230.0, 87.5, 71.5, 176, 144)
TIP = np.array([0.0, 0.0, 400.0])
START = RigidTransform(np.eye(3), -TIP)


def _ball(radius: float) -> np.ndarray:
    v, u = np.indices((144, 176))
    x, y = (u - 87.5) * 400 / 230, (v - 71.5) * 400 / 230
    inside = radius**2 - x**2 - y**2
    return np.where(inside > 0, 400 + radius - np.sqrt(np.maximum(inside, 0)), np.nan)


def _two_left_halves() -> np.ndarray:
    """A face whose right half is its left half again, shifted: no head looks like this."""
    depth = simulate.render(simulate.head(3), CAMERA, simulate.pose()).image.depth
    return np.hstack([depth[:, :88], depth[:, :88]])


DEGENERATE = {
    "plane": np.full((144, 176), 400.0),
    "slanted plane": 400.0 + 1.5 * np.indices((144, 176))[1] - 132.0,
    "ball": _ball(90.0),
    "large ball": _ball(250.0),
    "twenty points": np.where(np.random.default_rng(1).random((144, 176)) < 8e-4, 400.0, np.nan),
    "points on a line": np.where(np.indices((144, 176))[0] == 72, 400.0, np.nan),
    "nothing": np.full((144, 176), np.nan),
}


@pytest.mark.parametrize("method", ["icp", "mirror", "symmetric"])
@pytest.mark.parametrize("name", DEGENERATE)
def test_a_surface_without_a_pose_is_refused(name: str, method: str) -> None:
    alignment = register.METHODS[method](Face(RangeImage(DEGENERATE[name], CAMERA), TIP))
    assert not alignment.converged
    assert alignment.reason is not None


@pytest.mark.parametrize("name", DEGENERATE)
def test_a_cloud_without_a_pose_is_refused(name: str) -> None:
    image = RangeImage(DEGENERATE[name], CAMERA)
    alignment = register.cloud(PointSet(image.points[image.mask]), START)
    assert not alignment.converged
    assert alignment.reason is not None


@pytest.mark.parametrize("name", DEGENERATE)
def test_no_face_is_found_in_it(name: str) -> None:
    faces = segment.slices(RangeImage(DEGENERATE[name], CAMERA))
    assert len(faces) == 0
    assert faces.reason is not None


def test_two_halves_that_are_no_mirror_images_have_no_pose() -> None:
    alignment = register.icp(Face(RangeImage(_two_left_halves(), CAMERA), TIP))
    mirrored = register.mirror(Face(RangeImage(_two_left_halves(), CAMERA), TIP))
    both = register.symmetric(Face(RangeImage(_two_left_halves(), CAMERA), TIP))
    for found in (alignment, mirrored, both):
        turned = np.rad2deg(np.abs(found.transform.head_angles)).max()
        assert not found.converged or turned < 10.0  # half a face is a face, in its own place


COLLINEAR = {
    "left_eye_outer": TIP + np.array([40, 0, 0]),
    "right_eye_outer": TIP - np.array([40, 0, 0]),
}


def test_collinear_landmarks_are_refused() -> None:
    alignment = register.landmarks(Face(RangeImage(_ball(90.0), CAMERA), TIP, COLLINEAR))
    assert (alignment.converged, alignment.reason) == (False, Reason.NOT_CONVERGED)


def test_a_missing_landmark_is_refused() -> None:
    alignment = register.landmarks(Face(RangeImage(_ball(90.0), CAMERA), TIP))
    assert (alignment.converged, alignment.reason) == (False, Reason.TOO_FEW_POINTS)


def test_landmarks_that_are_no_face_are_refused() -> None:
    far = {
        "left_eye_outer": TIP + np.array([140, -40, 40]),
        "right_eye_outer": TIP - np.array([140, 40, -40]),
    }
    alignment = register.landmarks(Face(RangeImage(_ball(90.0), CAMERA), TIP, far))
    assert (alignment.converged, alignment.reason) == (False, Reason.POOR_FIT)


FACE = Face(RangeImage(_ball(90.0), CAMERA), TIP)
WRONG = {
    "names": lambda: register.landmarks(FACE, names=("nose_tip", "chin")),
    "names: .*elbow": lambda: register.landmarks(FACE, names=("nose_tip", "chin", "elbow")),
    "radius_mm": lambda: register.mirror(FACE, radius_mm=0.0),
    "points": lambda: register.icp(FACE, points=10),
    "max_angle_deg": lambda: register.icp(FACE, max_angle_deg=0.0),
    "radius_mm must": lambda: register.symmetric(FACE, radius_mm=0.0),
    "max_change_deg": lambda: register.symmetric(FACE, max_change_deg=-1.0),
    "points must": lambda: register.symmetric(FACE, points=10),
    "folds_mm": lambda: simulate.shoulders(folds_mm=-1.0, rng=np.random.default_rng(0)),
    "wrinkles_mm": lambda: simulate.cushion(wrinkles_mm=-1.0, rng=np.random.default_rng(0)),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_parameter_is_named(name: str) -> None:
    with pytest.raises(ParameterError, match=name):
        WRONG[name]()
