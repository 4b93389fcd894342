"""Rendering, poses and sequences: geometry that must be exact."""

from dataclasses import replace

import numpy as np
import pytest

from rangeface import sensors, simulate
from rangeface.simulate import Motion
from rangeface.types import Orthographic, Pinhole

SENSOR = sensors.preset("sr3000")


def test_a_pose_turns_as_the_head_angles_say():
    motion = simulate.pose(yaw_deg=25.0, pitch_deg=-10.0, roll_deg=5.0)
    angles = np.degrees(motion.inverse().head_angles)
    np.testing.assert_allclose(angles, [25.0, -10.0, 5.0], atol=1e-9)


def test_the_nose_tip_is_seen_where_the_pose_puts_it():
    place = (20.0, -10.0, 450.0)
    scene = simulate.render(simulate.mean_head(), SENSOR.camera, simulate.pose(nose_tip_mm=place))
    u, v = SENSOR.camera.project(np.array(place))
    depth = scene.image.depth[round(v), round(u)]
    assert depth == pytest.approx(450.0, abs=1.0)


@pytest.mark.parametrize(
    "camera", [Pinhole(200, 200, 40.3, 30.1, 80, 60), Orthographic(2.0, 40.3, 30.1, 80, 60)]
)
def test_oversampling_keeps_the_middle_sample(camera):
    head, away = simulate.head(1), simulate.pose()
    plain = simulate.render(head, camera, away)
    fine = simulate.render(head, camera, away, oversample=3)
    assert fine.depth.shape == (180, 240)
    both = plain.image.mask & fine.image.mask
    np.testing.assert_allclose(fine.image.depth[both], plain.image.depth[both], atol=0.01)
    assert (plain.image.mask ^ fine.image.mask).mean() < 0.002


def test_the_nearer_of_two_people_hides_the_other():
    heads = [simulate.head(0), simulate.head(1)]
    poses = [simulate.pose(nose_tip_mm=(0, 0, z)) for z in (600.0, 400.0)]
    scene = simulate.render(heads, SENSOR.camera, poses)
    assert (scene.part == 1).sum() > 4000
    middle = scene.part[71, 87]
    assert middle == 1


def test_the_triangle_of_a_sample_is_that_of_its_surface():
    heads = [simulate.head(0), simulate.head(1)]
    poses = [simulate.pose(nose_tip_mm=(x, 0, 700.0)) for x in (-130.0, 130.0)]
    scene = simulate.render([*heads, simulate.wall(1500.0)], SENSOR.camera, [*poses, None])
    assert set(np.unique(scene.part)) == {0, 1, 2}
    for part, head in enumerate(heads):
        seen = scene.part == part
        assert scene.triangle[seen].max() < len(head.surface.triangles)
        corners = head.surface.points[head.surface.triangles[scene.triangle[seen]]]
        there = poses[part].apply(corners.mean(axis=1))[:, 2]
        assert np.abs(there - scene.depth[seen]).max() < 40.0


def test_eyes_reflect_less_than_skin_and_shine_when_they_face_the_lamp():
    scene = simulate.render(simulate.mean_head(), SENSOR.camera, simulate.pose(), oversample=3)
    assert scene.shine.max() > 0.3
    eye = scene.shine > 0.3
    light = simulate.amplitude(scene, SENSOR)
    dull = simulate.amplitude(replace(scene, shine=0 * scene.shine), SENSOR)
    assert (light - dull)[eye].max() > 0.1 * np.median(dull[dull > 0])


def test_a_ball_is_round():
    ball = simulate.ball(40.0, (1.0, 2.0, 500.0), rings=32)
    radius = np.linalg.norm(ball.points - np.array([1.0, 2.0, 500.0], np.float32), axis=1)
    np.testing.assert_allclose(radius, 40.0, rtol=1e-5)


# ── sequences ────────────────────────────────────────────────────────────────────────────


def frames(people=2, **changes):
    options = {"frames": 3, "oversample": 1, "rng": np.random.default_rng(0)} | changes
    return list(simulate.sequence([simulate.head(i) for i in range(people)], SENSOR, **options))


def test_a_sequence_is_deterministic():
    for first, again in zip(frames(), frames(), strict=True):
        np.testing.assert_array_equal(first.image.depth, again.image.depth)
        assert first.time_s == again.time_s


def test_the_truth_is_where_the_people_are_seen():
    for frame in frames():
        for motion in frame.poses:
            u, v = SENSOR.camera.project(motion.translation)
            if 3 < u < 172 and 3 < v < 140:
                depth = frame.scene.image.depth[round(v), round(u)]
                assert depth == pytest.approx(motion.translation[2], abs=3.0)


def test_people_move_smoothly_and_within_their_amplitudes():
    motion = Motion(place_mm=(0.0, 0.0, 500.0), sway_mm=20.0, yaw_deg=15.0, seed=4)
    times = np.linspace(0.0, 10.0, 401)
    places = np.array([motion.at(t).translation for t in times])
    yaw = np.degrees([motion.at(t).inverse().head_angles[0] for t in times])
    assert np.abs(places - [0.0, 0.0, 500.0]).max() <= 20.0
    assert np.abs(yaw).max() <= 15.0
    assert np.ptp(yaw) > 12.0
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 5.0


def test_slow_buckets_blur_a_moving_person():
    motions = [Motion(sway_mm=60.0, period_s=0.5, seed=1)]
    sensor = SENSOR.ideal()
    person = [simulate.head(0)]
    options = {"motions": motions, "frames": 4, "oversample": 1, "wall_mm": None}

    def error(bucket_s):
        rng = np.random.default_rng(0)
        run = simulate.sequence(person, sensor, bucket_s=bucket_s, rng=rng, **options)
        return np.mean([np.nanmedian(np.abs(f.image.depth - f.scene.image.depth)) for f in run])

    assert error(0.0) < 0.05
    assert error(0.01) > 3 * error(0.001) > 0
