"""Rotations form a group; head angles and best fits invert what made them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rangeface.errors import DegenerateError, ParameterError
from rangeface.numerics import se3
from rangeface.types import RigidTransform

angle = st.floats(-1.4, 1.4)
vector = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)


@given(vector)
def test_rodrigues_gives_proper_rotations_with_that_axis_and_angle(w: np.ndarray) -> None:
    R = se3.rotation_matrix(w)
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    assert np.allclose(R @ w, w, atol=1e-12)
    theta = np.linalg.norm(w) % (2 * np.pi)
    assert se3.rotation_angle(R) == pytest.approx(min(theta, 2 * np.pi - theta), abs=1e-7)


@given(angle, angle, angle)
def test_head_angles_invert_head_rotation(yaw: float, pitch: float, roll: float) -> None:
    assert np.allclose(se3.head_angles(se3.head_rotation(yaw, pitch, roll)), (yaw, pitch, roll))


@given(vector, vector, st.integers(0, 2**32 - 1))
def test_best_fit_recovers_the_motion_of_noise_free_points(w, t, seed) -> None:
    source = np.random.default_rng(seed).normal(size=(6, 3))
    R = se3.rotation_matrix(w)
    found_R, found_t = se3.best_fit(source, source @ R.T + t)
    assert np.allclose(found_R, R, atol=1e-8)
    assert np.allclose(found_t, t, atol=1e-8)


def test_best_fit_never_mirrors() -> None:
    source = np.random.default_rng(0).normal(size=(8, 3))
    R, _ = se3.best_fit(source, source * [-1, 1, 1])
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_transforms_compose_and_invert_and_name_their_frames() -> None:
    a = RigidTransform(se3.rotation_matrix([0.1, 0.2, 0.3]), [1, 2, 3], "face", "camera")
    assert np.allclose((a @ a.inverse()).rotation, np.eye(3))
    assert (a @ a.inverse()).source == "face"
    with pytest.raises(ParameterError, match="cannot compose"):
        a @ a


@pytest.mark.parametrize(
    "points", [np.zeros((2, 3)), np.outer(np.arange(5.0), [1, 2, 3]), np.zeros((4, 2))]
)
def test_best_fit_refuses_what_leaves_a_rotation_open(points: np.ndarray) -> None:
    with pytest.raises(DegenerateError):
        se3.best_fit(points, points)
