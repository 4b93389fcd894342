"""Every sensor of the table, and both populations, keep one contract."""

import inspect
import os
from pathlib import Path

import numpy as np
import pytest

from rangeface import sensors, simulate
from rangeface.types import RangeImage

NPZ = (
    Path(os.environ.get("RANGEFACE_DATA", Path(__file__).parents[3] / "shared" / "data"))
    / "ict_facekit"
    / "ict_facekit_mm.npz"
)


@pytest.mark.parametrize("name", sorted(sensors.PRESETS))
def test_every_preset_captures_a_face(name):
    sensor = sensors.preset(name)
    distance = 400.0 if name in ("sr3000", "paper") else 600.0
    away = simulate.pose(nose_tip_mm=(0.0, 0.0, distance))
    scene = simulate.render(simulate.head(0), sensor.camera, away)
    image, again = (simulate.capture(scene, sensor, rng=np.random.default_rng(3)) for _ in range(2))
    assert isinstance(image, RangeImage)
    assert image.depth.shape == (sensor.camera.height, sensor.camera.width)
    np.testing.assert_array_equal(image.depth, again.depth)
    row, column = (round(c) for c in (sensor.camera.cy, sensor.camera.cx))
    nose = (slice(row - 3, row + 4), slice(column - 3, column + 4))
    assert image.mask[nose].mean() > 0.9
    error = (image.depth - scene.image.depth)[nose]
    assert np.abs(np.nanmedian(error)) < 20.0
    assert np.isfinite(image.sigma[image.mask]).all()
    assert (image.sigma[image.mask] > 0).all()
    assert (np.isfinite(image.depth) == image.mask).all()
    assert sensor.source


def test_every_principle_has_a_method():
    assert set(simulate.METHODS) == set(sensors.PRINCIPLES)
    for method in simulate.METHODS.values():
        assert inspect.signature(method).parameters["rng"].kind is inspect.Parameter.KEYWORD_ONLY


def test_a_scene_is_not_changed_by_its_capture():
    sensor = sensors.preset("sr3000")
    scene = simulate.render(simulate.head(0), sensor.camera, simulate.pose(), oversample=3)
    before = {name: getattr(scene, name).copy() for name in ("depth", "reflectivity", "normal")}
    simulate.capture(scene, sensor, rng=np.random.default_rng(0))
    for name, plane in before.items():
        np.testing.assert_array_equal(getattr(scene, name), plane)


# ── a second population through the same interface ───────────────────────────────────────


def folder_of_a_model(path, *, rows=9, modes=3):
    """A miniature in the layout of ICT-FaceKit: OBJ files, centimetres, y up, z forward."""
    folder = path / "FaceXModel"
    folder.mkdir(parents=True)
    y, x = (a.ravel() for a in np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : rows * 1j])
    face = np.stack([8 * x, 8 * y, 6 * np.exp(-3 * (x**2 + y**2))], axis=-1)
    cell = np.arange(rows * (rows - 1)).reshape(rows - 1, rows)[:, :-1].ravel() + 1
    quads = np.stack([cell, cell + 1, cell + rows + 1, cell + rows], axis=-1)

    def write(name, points):
        lines = [f"v {a:.6f} {b:.6f} {c:.6f}" for a, b, c in points]
        lines += ["vt 0 0", "vn 0 0 1"]
        lines += ["f " + " ".join(f"{i}/1/1" for i in quad) for quad in quads]
        (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")

    write("generic_neutral_mesh", face)
    rng = np.random.default_rng(0)
    for mode in range(modes):
        write(f"identity{mode:03d}", face + 0.1 * rng.standard_normal(face.shape))
    low = (y < -0.3)[:, None] * np.array([0.0, -1.0, 0.0])
    for name in ("jawOpen", "mouthSmile_L", "mouthSmile_R"):
        write(name, face + low)
    return face


def test_the_folder_layout_is_read_in_millimetres_and_turned(tmp_path):
    face = folder_of_a_model(tmp_path)
    model = simulate.ict_facekit(tmp_path)
    tip = face[np.argmax(face[:, 2])]
    expected = 10.0 * (face - tip) * [1.0, -1.0, -1.0]
    np.testing.assert_allclose(model.mean, expected, atol=1e-4)
    assert model.identity.shape == (3, 81, 3)
    assert set(model.expressions) == {"jawOpen", "mouthSmile_L", "mouthSmile_R"}
    assert len(model.triangles) == 2 * 64
    direct = simulate.ict_facekit(tmp_path / "FaceXModel")
    np.testing.assert_array_equal(direct.mean, model.mean)


def test_a_head_of_the_model_renders_like_any_other(tmp_path):
    folder_of_a_model(tmp_path)
    model = simulate.ict_facekit(tmp_path)
    first, again = model.head(4), model.head(4)
    np.testing.assert_array_equal(first.surface.points, again.surface.points)
    assert np.abs(model.head(5).surface.points - first.surface.points).max() > 0.1
    laugh = model.head(4, expression="laugh").surface.points
    assert (laugh - first.surface.points)[:, 1].max() > 4.0  # down is positive
    other = model.head(4, expression="random", session=1).surface.points
    assert np.abs(other - first.surface.points).max() > 0.0
    sensor = sensors.preset("sr3000")
    scene = simulate.render(first, sensor.camera, simulate.pose())
    assert scene.image.mask.sum() > 1000


def test_a_model_refuses_what_our_population_refuses(tmp_path):
    folder_of_a_model(tmp_path)
    model = simulate.ict_facekit(tmp_path)
    for options, name in (
        ({"seed": -1}, "seed"),
        ({"seed": 0, "expression": "sneeze"}, "expression"),
        ({"seed": 0, "strength": -1.0}, "strength"),
    ):
        with pytest.raises(ValueError, match=name):
            model.head(**options)


@pytest.mark.skipif(not NPZ.is_file(), reason="needs the ICT-FaceKit file of the shared data")
def test_the_npz_of_the_model_is_a_face():
    model = simulate.ict_facekit(NPZ)
    assert model.identity.shape[0] == 100
    assert len(model.expressions) == 55
    head = model.head(0)
    assert (
        np.abs(head.surface.points[np.argmin(np.linalg.norm(head.surface.points, axis=1))]).max()
        < 1
    )
    spread = head.surface.points.max(axis=0) - head.surface.points.min(axis=0)
    assert 200 < spread[1] < 450
