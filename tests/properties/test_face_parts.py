"""What is cut out of an image around a face, and the landmarks and incidence on it."""

from __future__ import annotations

import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface import register, segment, simulate
from rangeface.errors import NoFaceError, ParameterError
from rangeface.io.reference import default_reference
from rangeface.types import (
    Alignment,
    Face,
    Orthographic,
    Pinhole,
    RangeImage,
    Reason,
    RigidTransform,
)

CAMERA = Pinhole(230.0, 230.0, 87.5, 71.5, 176, 144)
FRONT = RigidTransform(np.eye(3), np.array([0.0, 0.0, -400.0]))


def _slope(a: float, b: float, camera: Pinhole = CAMERA) -> RangeImage:
    """z = 400 + a x + b y, mm, as the camera sees it."""
    v, u = np.indices((camera.height, camera.width))
    rays = 1.0 - a * (u - camera.cx) / camera.fx - b * (v - camera.cy) / camera.fy
    return RangeImage(400.0 / rays, camera)


@pytest.mark.parametrize("size", [(50, 80), (25, 40), (100, 160)])
def test_a_rectangle_has_the_extent_it_was_asked_for_at_any_size(size: tuple[int, int]) -> None:
    width, height = size
    crop = segment.rectangle(_slope(0.3, -0.2), FRONT, width=width, height=height)
    assert crop.shape == (height, width)
    camera = crop.camera
    assert isinstance(camera, Orthographic)
    assert camera.pitch_mm * width == pytest.approx(100.0)
    x, y = np.meshgrid(
        (np.arange(width) - camera.cx) * camera.pitch_mm,
        (np.arange(height) - camera.cy) * camera.pitch_mm,
    )
    assert np.abs(crop.depth - (0.3 * x - 0.2 * y))[crop.mask].max() < 0.1
    assert crop.mask.mean() > 0.95


def test_a_rectangle_of_a_registered_face_is_its_frontal_image() -> None:
    image, pose = sr3000_face(yaw=20.0)
    face = Face(image, pose.translation, pose=pose.inverse())
    alignment = register.symmetric(face)
    crop = segment.rectangle(image, alignment.transform)
    frontal = register.frontal.resample(
        face, alignment, width_mm=100.0, height_mm=160.0, fill=False
    )
    both = crop.mask & frontal.mask
    assert both.mean() > 0.6
    assert np.median(np.abs(crop.depth - frontal.depth)[both]) < 0.05
    assert crop.sigma is not None
    assert crop.amplitude is not None


def test_a_rectangle_drops_what_is_far_before_or_behind() -> None:
    depth = np.full((144, 176), 400.0)
    depth[:, 100:] = 700.0
    crop = segment.rectangle(RangeImage(depth, CAMERA), FRONT, depth_mm=100.0)
    assert np.nanmax(np.abs(crop.depth)) <= 100.0
    assert not crop.mask[:, -5:].any()


WRONG = {
    "width_mm": lambda: segment.rectangle(_slope(0, 0), FRONT, width_mm=0.0),
    "height_mm": lambda: segment.rectangle(_slope(0, 0), FRONT, height_mm=-1.0),
    "depth_mm": lambda: segment.rectangle(_slope(0, 0), FRONT, depth_mm=0.0),
    "square pixels": lambda: segment.rectangle(_slope(0, 0), FRONT, width_mm=140.0),
    "radius_mm": lambda: segment.sphere(_slope(0, 0), np.zeros(3), 0.0),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_extent_is_named(name: str) -> None:
    with pytest.raises(ParameterError, match=name):
        WRONG[name]()


def test_a_rectangle_beside_everything_holds_no_face() -> None:
    away = RigidTransform(np.eye(3), np.array([0.0, 0.0, -4000.0]))
    with pytest.raises(NoFaceError, match="rectangle"):
        segment.rectangle(_slope(0, 0), away)
    with pytest.raises(NoFaceError, match="rectangle"):
        segment.rectangle(RangeImage(np.full((144, 176), np.nan), CAMERA), FRONT)


def test_a_sphere_holds_its_points_and_no_other() -> None:
    image = _slope(0.2, 0.0)
    crop = segment.sphere(image, [10.0, 5.0, 402.0], 50.0)
    distance = np.linalg.norm(crop.points[crop.mask] - [10.0, 5.0, 402.0], axis=-1)
    inside = np.linalg.norm(image.points - [10.0, 5.0, 402.0], axis=-1) <= 50.0
    assert distance.max() <= 50.0 + 1e-3
    assert crop.mask.sum() == inside.sum()


# ── landmarks ────────────────────────────────────────────────────────────────────────────

NAMES = ("nose_root", "chin", "left_eye_inner", "right_eye_inner", "left_eye_outer",
         "right_eye_outer")  # fmt: skip


def _landmark_errors(person: int, noise_mm: float) -> tuple[list[float], list[float]]:
    """Distances to the truth: of the landmarks found, and of the reference's carried over."""
    pose = simulate.pose(yaw_deg=8.0, nose_tip_mm=(0.0, 0.0, 420.0))
    head = simulate.head(person)
    image = simulate.render(head, CAMERA, pose).image
    image = simulate.add_noise(image, noise_mm, rng=np.random.default_rng(person))
    face = segment.slices(image)[0]
    alignment = register.symmetric(face)
    found = segment.landmarks(face, alignment)
    back = alignment.transform.inverse()
    carried = simulate.mean_head().landmarks
    truth = {name: pose.apply(head.landmarks[name]) for name in NAMES}
    return (
        [float(np.linalg.norm(found[n] - truth[n])) for n in NAMES],
        [float(np.linalg.norm(back.apply(carried[n]) - truth[n])) for n in NAMES],
    )


@pytest.mark.parametrize("noise_mm", [0.3, 1.5])
def test_landmarks_lie_nearer_to_the_truth_than_the_references(noise_mm: float) -> None:
    errors = [_landmark_errors(person, noise_mm) for person in range(6)]
    own, carried = (np.array(e) for e in zip(*errors, strict=True))
    assert np.median(own) < 0.8 * np.median(carried)
    assert np.median(own) < 5.0


def test_landmarks_are_where_a_face_has_them() -> None:
    image, pose = sr3000_face()
    face = Face(image, pose.translation, pose=pose.inverse())
    alignment = register.symmetric(face)
    found = segment.landmarks(face, alignment)
    assert {"nose_tip", "forehead", *NAMES} <= set(found)
    upright = {name: alignment.transform.apply(place) for name, place in found.items()}
    assert np.allclose(upright["nose_tip"], 0.0, atol=1e-9)
    assert upright["forehead"][1] < upright["nose_root"][1] < 0.0 < upright["chin"][1]
    assert upright["left_eye_outer"][0] > upright["left_eye_inner"][0] > 0.0
    assert upright["right_eye_inner"][0] == pytest.approx(-upright["left_eye_inner"][0], abs=1e-6)


def test_hidden_places_keep_the_references_prior() -> None:
    """Below the nose alone is seen: the eyes stay where the reference has them."""
    image, pose = sr3000_face()
    low = image.points[..., 1] > pose.translation[1] - 10.0
    face = Face(image.masked(low), pose.translation, pose=pose.inverse())
    found = segment.landmarks(face, Alignment(pose.inverse()))
    expected = pose.apply(default_reference().landmarks["nose_root"])
    assert np.linalg.norm(found["nose_root"] - expected) < 1e-6


def test_a_refused_alignment_has_no_landmarks() -> None:
    refused = Alignment(FRONT, converged=False, reason=Reason.POOR_FIT)
    with pytest.raises(NoFaceError, match="refused"):
        segment.landmarks(Face(_slope(0, 0), [0.0, 0.0, 400.0]), refused)
    nothing = RangeImage(np.full((144, 176), np.nan), CAMERA)
    with pytest.raises(NoFaceError, match="rectangle"):
        segment.landmarks(Face(nothing, [0.0, 0.0, 400.0]), Alignment(FRONT))


# ── incidence ────────────────────────────────────────────────────────────────────────────


def _incidence(image: RangeImage, transform: RigidTransform) -> tuple[np.ndarray, RangeImage]:
    face, alignment = Face(image, [0.0, 0.0, 400.0]), Alignment(transform)
    frontal = register.frontal.resample(face, alignment, width_mm=70.0, height_mm=112.0)
    return register.frontal.incidence(frontal, face, alignment), frontal


@pytest.mark.parametrize(("a", "b"), [(0.0, 0.0), (0.5, 0.0), (-0.3, 0.4)])
def test_the_incidence_on_a_slope_is_that_of_its_rays(a: float, b: float) -> None:
    cosines, frontal = _incidence(_slope(a, b), FRONT)
    points = frontal.points.astype(float) + np.array([0.0, 0.0, 400.0])
    normal = np.array([a, b, -1.0]) / np.sqrt(1.0 + a * a + b * b)
    expected = -(points / np.linalg.norm(points, axis=-1, keepdims=True)) @ normal
    assert np.nanmax(np.abs(cosines - expected)) < 0.01
    assert cosines.shape == frontal.shape


def test_the_incidence_does_not_depend_on_the_frame_that_the_surface_is_turned_to() -> None:
    """A wall before the camera meets its rays as before, however the face frame lies."""
    turn = simulate.pose(yaw_deg=25.0, nose_tip_mm=(0.0, 0.0, 400.0)).inverse()
    straight, _ = _incidence(_slope(0.0, 0.0), FRONT)
    turned, _ = _incidence(_slope(0.0, 0.0), turn)
    assert turned[40, 25] == pytest.approx(straight[40, 25], abs=0.01)


def test_parallel_rays_have_one_direction() -> None:
    camera = Orthographic(2.0, 49.5, 69.5, 100, 140)
    y, x = (np.indices((140, 100)) - np.array([69.5, 49.5])[:, None, None]) * 2.0
    cosines, _ = _incidence(RangeImage(400.0 + 0.75 * x + 0 * y, camera), FRONT)
    assert np.nanmax(np.abs(cosines - 0.8)) < 0.01


def test_what_was_filled_or_is_no_depth_has_no_incidence() -> None:
    image, pose = sr3000_face(yaw=30.0)
    face = Face(image, pose.translation, pose=pose.inverse())
    alignment = register.symmetric(face)
    frontal = register.frontal.resample(face, alignment)
    cosines = register.frontal.incidence(frontal, face, alignment)
    assert frontal.filled is not None
    assert np.isnan(cosines[frontal.filled]).all()
    assert np.isfinite(cosines[~frontal.filled]).mean() > 0.95
    assert np.nanmin(cosines) >= 0.0
    assert np.nanmax(cosines) <= 1.0
    with pytest.raises(ParameterError, match="frontal"):
        register.frontal.incidence(image, face, alignment)
