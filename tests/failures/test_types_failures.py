"""Every Raises line of the types, the finder, the frontal grid and the assessment."""

from __future__ import annotations

import numpy as np
import pytest

from rangeface import assess, register, segment
from rangeface.errors import DegenerateError, ParameterError
from rangeface.types import (
    Alignment,
    Face,
    Orthographic,
    Pinhole,
    PointSet,
    RangeImage,
    ReferenceFace,
    RigidTransform,
)

GOOD = {"fx": 200.0, "fy": 200.0, "cx": 1.0, "cy": 1.0, "width": 3, "height": 3}
CAMERA = Pinhole(**GOOD)
IMAGE = RangeImage(np.full((3, 3), 400.0), CAMERA)
FACE = Face(IMAGE, nose_tip=[0.0, 0.0, 400.0])
MOVE = RigidTransform(np.eye(3), [0, 0, -400.0])


@pytest.mark.parametrize(
    ("name", "value"),
    [("fx", 0.0), ("fy", -1.0), ("fx", np.nan), ("fy", np.inf), ("cx", np.nan), ("cy", np.inf),
     ("width", 0), ("height", -3)],
)  # fmt: skip
def test_an_impossible_camera_names_its_parameter(name: str, value: float) -> None:
    with pytest.raises(ParameterError, match=name):
        Pinhole(**{**GOOD, name: value})


@pytest.mark.parametrize("pitch", [0.0, -1.0, np.nan, np.inf])
def test_an_impossible_pitch_is_refused(pitch: float) -> None:
    with pytest.raises(ParameterError, match="pitch_mm"):
        Orthographic(pitch, 0, 0, 2, 2)


def test_planes_must_fit_and_depth_must_not_be_infinite() -> None:
    with pytest.raises(ParameterError, match="depth: shape"):
        RangeImage(np.zeros((2, 3)), CAMERA)
    with pytest.raises(ParameterError, match="sigma: shape"):
        RangeImage(np.zeros((3, 3)), CAMERA, sigma=np.zeros((2, 2)))
    with pytest.raises(ParameterError, match="infinite"):
        RangeImage(np.full((3, 3), np.inf), CAMERA)


def test_images_are_read_only_and_keep_the_callers_array() -> None:
    depth = np.full((3, 3), 400.0, np.float32)
    image = RangeImage(depth, CAMERA)
    depth[0, 0] = 1.0
    assert image.depth[0, 0] == 400.0
    with pytest.raises(ValueError, match="read-only"):
        image.depth[0, 0] = 1.0


def test_a_window_outside_the_image_is_refused() -> None:
    with pytest.raises(ParameterError, match="outside"):
        IMAGE.crop(5, 5, 2, 2)


def test_point_sets_must_be_finite_with_indices_in_range() -> None:
    with pytest.raises(ParameterError, match="expected"):
        PointSet(np.zeros((3, 2)))
    with pytest.raises(ParameterError, match="finite"):
        PointSet([[0.0, 0.0, np.nan]])
    with pytest.raises(ParameterError, match="triangles: expected"):
        PointSet(np.zeros((3, 3)), [[0, 1]])
    with pytest.raises(ParameterError, match="outside the points"):
        PointSet(np.zeros((3, 3)), [[0, 1, 3]])


def test_a_reflection_cannot_be_a_motion() -> None:
    for wrong in (np.diag([-1.0, 1.0, 1.0]), 2 * np.eye(3)):
        with pytest.raises(ParameterError, match="proper rotation"):
            RigidTransform(wrong, np.zeros(3))
    with pytest.raises(ParameterError, match="finite"):
        RigidTransform(np.eye(3), [np.nan, 0, 0])


def test_a_reference_needs_a_parallel_camera_and_enough_pixels() -> None:
    with pytest.raises(ParameterError, match="orthographic"):
        ReferenceFace(IMAGE)
    with pytest.raises(DegenerateError, match="100 valid pixels"):
        ReferenceFace(RangeImage(np.zeros((5, 5)), Orthographic(2.0, 2, 2, 5, 5)))


@pytest.mark.parametrize(
    ("name", "value"),
    [("radius_mm", 0.0), ("min_gap_mm", -1.0), ("max_yaw_deg", 80.0), ("max_faces", 0),
     ("min_confidence", 1.5)],
)  # fmt: skip
def test_the_finder_names_a_wrong_parameter(name: str, value: float) -> None:
    with pytest.raises(ParameterError, match=name):
        segment.slices(IMAGE, **{name: value})


def test_registration_and_the_frontal_grid_name_a_wrong_parameter() -> None:
    with pytest.raises(ParameterError, match="points"):
        register.icp(FACE, points=10)
    with pytest.raises(ParameterError, match="max_angle_deg"):
        register.icp(FACE, max_angle_deg=0)
    for name in ("radius_mm", "sigma_px"):
        with pytest.raises(ParameterError, match=name):
            register.frontal.resample(FACE, Alignment(MOVE), **{name: 0.0})
    with pytest.raises(ParameterError, match="square pixels"):
        register.frontal.resample(FACE, Alignment(MOVE), width_mm=100.0)


@pytest.mark.parametrize("name", ["max_yaw_deg", "max_pitch_deg", "max_roll_deg", "max_sigma_mm"])
def test_the_assessment_names_a_wrong_limit(name: str) -> None:
    with pytest.raises(ParameterError, match=name):
        assess.quality(FACE, Alignment(MOVE), IMAGE, **{name: 0.0})
    with pytest.raises(ParameterError, match="min_distance_mm"):
        assess.quality(FACE, Alignment(MOVE), IMAGE, min_distance_mm=9e9)
