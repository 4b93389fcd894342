"""The projective ICP finds the pose that made the image, and its parts equal plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from rangeface import simulate
from rangeface.io.reference import default_reference
from rangeface.numerics import icp, se3
from rangeface.types import Pinhole

CAMERA = Pinhole(230.0, 230.0, 87.5, 71.5, 176, 144)
GATES = np.array([25] * 6 + [12] * 14, np.float32)
SCALES = np.array([9] * 6 + [3] * 14, np.float32)
START = [(10.0, -8.0, 6.0, 8.0), (-12.0, 10.0, -8.0, -8.0), (5.0, 12.0, 10.0, 5.0)]


def _image(pose: simulate.RigidTransform | object) -> np.ndarray:
    return simulate.render(simulate.mean_head(), CAMERA, pose).image.points


def _model(count: int = 1500) -> icp.Model:
    return icp.Model(*default_reference().surface(count))


def _align(image: np.ndarray, R: np.ndarray, t: np.ndarray) -> icp.Fit:
    weights = np.ones(image.shape[:2], np.float32)
    return icp.align(
        _model(), CAMERA.projection, image, weights, R, t, gates_mm=GATES, scales_mm=SCALES
    )


@pytest.mark.parametrize(("yaw", "pitch", "roll", "shift"), START)
def test_the_pose_of_the_mean_head_is_found_from_a_rough_start(yaw, pitch, roll, shift) -> None:
    pose = simulate.pose(yaw_deg=8.0, pitch_deg=-5.0, nose_tip_mm=(10.0, 5.0, 420.0))
    turn = se3.head_rotation(*np.deg2rad([yaw, pitch, roll]))
    fit = _align(_image(pose), turn @ pose.rotation, pose.translation + shift)
    assert np.rad2deg(se3.rotation_angle(fit.rotation @ pose.rotation.T)) < 1.0
    assert np.linalg.norm(fit.translation - pose.translation) < 1.5
    assert fit.overlap > 0.9
    assert fit.rms_mm < 1.0
    assert fit.moved_mm < 0.1


def test_an_image_without_points_gives_no_inliers_and_no_number() -> None:
    image = np.full((144, 176, 3), np.nan, np.float32)
    fit = _align(image, np.eye(3), np.array([0.0, 0.0, 400.0]))
    assert fit.inliers == 0
    assert np.isnan(fit.rms_mm)
    assert not np.isfinite(fit.moved_mm)


def test_scores_equal_the_definition_written_in_numpy() -> None:
    pose = simulate.pose(yaw_deg=10.0, nose_tip_mm=(0.0, 0.0, 400.0))
    image, model = _image(pose), _model(150)
    R = np.stack([pose.rotation, np.eye(3), se3.head_rotation(0.5, 0.1, 0.0)])
    t = np.stack([pose.translation, pose.translation + 3.0, pose.translation])
    found = icp.scores(model, R, t, CAMERA.projection, image, tolerance_mm=8.0)
    wanted = [_score(model, R_k, t_k, image, 8.0) for R_k, t_k in zip(R, t, strict=True)]
    assert found == pytest.approx(wanted, abs=2e-3)
    assert found[0] == found.max()


def _score(model: icp.Model, R: np.ndarray, t: np.ndarray, image: np.ndarray, tol: float) -> float:
    p, n, w = (a.astype(np.float64) for a in model)
    x, m = p @ R.T + t, n @ R.T
    facing = -(x * m).sum(axis=1) / np.linalg.norm(x, axis=1)
    visible = facing >= 0.15
    col, row = np.floor(CAMERA.project(x) + 0.5).astype(int).T
    inside = (col >= 0) & (row >= 0) & (col < 176) & (row < 144)
    d = np.where(inside[:, None], image[np.clip(row, 0, 143), np.clip(col, 0, 175)], np.nan) - x
    r = (m * d).sum(axis=1) / tol
    near = (r**2 < 1) & ((d**2).sum(axis=1) < 16 * tol**2) & visible
    explained = (w * np.where(near, 1 - r**2, 0)).sum()
    return float(explained / max(w[visible].sum(), 0.5 * w.sum()))


def test_relief_tells_a_face_from_a_smooth_surface() -> None:
    pose = simulate.pose(nose_tip_mm=(0.0, 0.0, 400.0))
    image = _image(pose)
    v, u = np.indices((144, 176))
    ball_z = 400.0 + ((u - 87.5) ** 2 + (v - 71.5) ** 2) / 60.0
    ball = CAMERA.back_project(ball_z)
    args = (pose.rotation, pose.translation, CAMERA.projection)
    assert icp.relief(_model(400), *args, image).correlation > 0.95
    assert icp.relief(_model(400), *args, ball).correlation < 0.5
