"""A face is followed from frame to frame, and its loss is noticed."""

from __future__ import annotations

import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface import config, register, segment, simulate
from rangeface.errors import ParameterError
from rangeface.types import Pinhole, RangeImage, Reason, RigidTransform

CAMERA = Pinhole(230.0, 230.0, 87.5, 71.5, 176, 144)
FRONTAL = simulate.pose(nose_tip_mm=(0.0, 0.0, 420.0))


def _frame(pose: RigidTransform, person: int = 1) -> RangeImage:
    return simulate.render(simulate.head(person), CAMERA, pose).image


def test_a_moving_and_turning_face_is_followed() -> None:
    way = simulate.Motion(place_mm=(0.0, 0.0, 430.0), sway_mm=40.0, yaw_deg=25.0, period_s=2.0)
    found = segment.slices(_frame(way.at(0.0)))[0].pose
    for frame in range(1, 12):
        true = way.at(frame / 10.0)
        faces = segment.follow(_frame(true), found)
        assert len(faces) == 1
        assert np.linalg.norm(faces[0].nose_tip - true.translation) < 10.0
        found = register.icp(faces[0]).transform


@pytest.mark.parametrize("step_mm", [20.0, 40.0, 60.0])
def test_a_jump_of_less_than_the_step_is_followed(step_mm: float) -> None:
    faces = segment.follow(_frame(simulate.pose(nose_tip_mm=(step_mm, 0, 420))), FRONTAL.inverse())
    assert np.linalg.norm(faces[0].nose_tip - [step_mm, 0.0, 420.0]) < 10.0


LOST = {
    "gone": simulate.render(simulate.wall(900.0), CAMERA).image,
    "too far": _frame(simulate.pose(nose_tip_mm=(110.0, 0.0, 420.0))),
    "another thing": simulate.render(simulate.ball(90.0, (0.0, 0.0, 500.0)), CAMERA).image,
}


@pytest.mark.parametrize("what", LOST)
def test_a_loss_is_noticed(what: str) -> None:
    faces = segment.follow(LOST[what], FRONTAL.inverse())
    assert len(faces) == 0
    assert faces.reason is Reason.LOST


def test_an_image_without_valid_pixels_is_not_a_loss() -> None:
    empty = RangeImage(np.full((144, 176), np.nan), CAMERA)
    assert segment.follow(empty, FRONTAL.inverse()).reason is Reason.NO_VALID_PIXELS


def test_the_crop_of_a_followed_face_is_the_sphere() -> None:
    face = segment.follow(_frame(FRONTAL), FRONTAL.inverse(), radius_mm=90.0)[0]
    distance = np.linalg.norm(face.image.points - face.nose_tip, axis=-1)
    assert np.nanmax(distance) <= 90.0 + 1e-3


def test_the_pipeline_follows_and_searches_anew_after_a_loss() -> None:
    pipeline = config.load_pipeline("full-n-mlda")
    first = pipeline.trace(sr3000_face(3)[0])
    second = pipeline.follow(sr3000_face(3, noise=1)[0], first)
    assert second.reason is None
    tips = [t.alignment.transform.inverse().translation for t in (first, second)]
    assert np.linalg.norm(tips[1] - tips[0]) < 4.0
    lost = pipeline.follow(LOST["gone"], second)
    assert lost.reason is Reason.LOST
    assert lost.frontal is None
    assert pipeline.follow(sr3000_face(3)[0], lost).reason is None


WRONG = {
    "pose": lambda image: segment.follow(image, FRONTAL),
    "radius_mm": lambda image: segment.follow(image, FRONTAL.inverse(), radius_mm=0.0),
    "max_step_mm": lambda image: segment.follow(image, FRONTAL.inverse(), max_step_mm=-1.0),
    "min_confidence": lambda image: segment.follow(image, FRONTAL.inverse(), min_confidence=2.0),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_parameter_is_named(name: str) -> None:
    with pytest.raises(ParameterError, match=name):
        WRONG[name](_frame(FRONTAL))
