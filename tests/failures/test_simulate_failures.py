"""Every refusal of the simulator names its parameter."""

from dataclasses import replace

import numpy as np
import pytest

from rangeface import sensors, simulate
from rangeface.errors import ParameterError, ScanError, ScanFault
from rangeface.numerics import draws
from rangeface.sensors import SensorModel
from rangeface.simulate import Head, Motion
from rangeface.types import Orthographic, PointSet, RangeImage

RNG = np.random.default_rng(0)
CAMERA = Orthographic(4.0, 19.5, 29.5, 40, 60)
IMAGE = RangeImage(np.full((60, 40), 300.0), CAMERA)
SCENE = simulate.render(simulate.mean_head(), sensors.preset("sr3000").camera, simulate.pose())


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("seed", {"seed": -1}),
        ("session", {"seed": 0, "session": -1}),
        ("expression", {"seed": 0, "expression": "sneeze"}),
        ("strength", {"seed": 0, "expression": "smile", "strength": 2.0}),
        ("sex", {"seed": 0, "sex": "robot"}),
        ("age", {"seed": 0, "age": 7}),
    ],
)
def test_a_head_that_cannot_be(name, options):
    with pytest.raises(ParameterError, match=name):
        simulate.head(**options)


def test_planes_of_a_head_fit_its_vertices():
    mesh = simulate.wall(100.0)
    with pytest.raises(ParameterError, match="tissue"):
        Head(mesh, np.zeros(3, np.int8), np.zeros(4, np.float32))
    with pytest.raises(ParameterError, match="reflectivity"):
        Head(mesh, np.zeros(4, np.int8), np.zeros(3, np.float32))


@pytest.mark.parametrize("oversample", [0, 2, -3])
def test_oversample_is_odd(oversample):
    with pytest.raises(ParameterError, match="oversample"):
        simulate.render(simulate.mean_head(), CAMERA, oversample=oversample)


def test_surfaces_need_triangles_and_poses():
    with pytest.raises(ParameterError, match="surfaces"):
        simulate.render(PointSet(np.zeros((3, 3), np.float32)), CAMERA)
    with pytest.raises(ParameterError, match="poses"):
        simulate.render([simulate.wall(1.0)], CAMERA, [simulate.pose(), simulate.pose()])


@pytest.mark.parametrize("method", ["tof", "buckets", "random_point", "triangulate"])
def test_each_principle_has_its_own_function(method):
    wrong = "laser-scanner" if method != "triangulate" else "sr3000"
    with pytest.raises(ParameterError, match="sensor"):
        getattr(simulate, method)(SCENE, sensors.preset(wrong), rng=RNG)


@pytest.mark.parametrize("count", [0, 2, 3, 5])
def test_one_scene_or_one_a_bucket(count):
    with pytest.raises(ParameterError, match="scene"):
        simulate.tof([SCENE] * count, sensors.preset("sr3000"), rng=RNG)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: simulate.add_noise(IMAGE, -1.0, rng=RNG), "sigma_mm"),
        (lambda: simulate.add_noise(IMAGE, float("nan"), rng=RNG), "sigma_mm"),
        (lambda: simulate.add_noise_psnr(IMAGE, 40.0, peak_mm=0.0, rng=RNG), "peak_mm"),
        (
            lambda: simulate.add_noise_psnr(IMAGE, float("inf"), peak_mm=1.0, rng=RNG),
            "psnr_db",
        ),
        (lambda: simulate.coarsen(IMAGE, 0), "factor"),
        (lambda: simulate.coarsen(IMAGE, 41), "factor"),
        (lambda: simulate.quantise(IMAGE, 0.0), "step_mm"),
        (lambda: simulate.punch_holes(IMAGE, 1.5, rng=RNG), "share"),
        (lambda: simulate.punch_holes(IMAGE, 0.1, radius_px=0.0, rng=RNG), "radius_px"),
        (lambda: simulate.degrade(IMAGE, pitch_mm=0.0, rng=RNG), "pitch_mm"),
        (
            lambda: simulate.degrade(IMAGE.masked(np.zeros((60, 40), bool)), rng=RNG),
            "image",
        ),
        (lambda: simulate.wall(0.0), "depth_mm"),
        (lambda: simulate.wall(1.0, half_mm=-1.0), "half_mm"),
        (lambda: simulate.ball(0.0), "radius_mm"),
        (lambda: simulate.ball(1.0, rings=2), "rings"),
        (lambda: draws.poisson([-1.0], rng=RNG), "mean"),
        (lambda: draws.poisson([float("nan")], rng=RNG), "mean"),
        (lambda: Motion(sway_mm=-1.0), "sway_mm"),
        (lambda: Motion(yaw_deg=-1.0), "yaw_deg"),
        (lambda: Motion(period_s=0.0), "period_s"),
    ],
)
def test_a_parameter_out_of_range_is_named(call, name):
    with pytest.raises(ParameterError, match=name):
        call()


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"people": []}, "people"),
        ({"frames": 0}, "frames"),
        ({"rate_hz": 0.0}, "rate_hz"),
        ({"bucket_s": -1.0}, "bucket_s"),
        ({"motions": []}, "motions"),
    ],
)
def test_a_sequence_is_refused_before_its_first_frame(options, name):
    people = options.pop("people", [simulate.mean_head()])
    with pytest.raises(ParameterError, match=name):
        simulate.sequence(people, sensors.preset("sr3000"), rng=RNG, **options)


# ── a user's own face model ──────────────────────────────────────────────────────────────


def test_a_missing_model_is_said_to_be_missing(tmp_path):
    for path in (tmp_path, tmp_path / "no.npz"):
        with pytest.raises(ScanError) as caught:
            simulate.ict_facekit(path)
        assert caught.value.fault is ScanFault.MISSING


def write(folder, name, text):
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(text)


MESH = "v 0 0 1\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.mark.parametrize(
    ("neutral", "identity", "fault"),
    [
        ("v 0 0 x\nf 1 1 1\n", MESH, ScanFault.MALFORMED),
        ("", MESH, ScanFault.MALFORMED),
        ("v 0 0 nan\nf 1 1 1\n", MESH, ScanFault.MALFORMED),
        ("v 0 0 1\nf 1 2 3\n", MESH, ScanFault.MALFORMED),
        ("v 0 0 1\n", MESH, ScanFault.MALFORMED),
        (MESH, "v 0 0 1\n", ScanFault.WRONG_SIZE),
        (MESH, None, ScanFault.MISSING),
    ],
)
def test_a_broken_model_names_its_fault(tmp_path, neutral, identity, fault):
    folder = tmp_path / "FaceXModel"
    write(folder, "generic_neutral_mesh.obj", neutral)
    if identity is not None:
        write(folder, "identity000.obj", identity)
    with pytest.raises(ScanError) as caught:
        simulate.ict_facekit(tmp_path)
    assert caught.value.fault is fault


def test_an_oversized_mesh_is_not_read(tmp_path, monkeypatch):
    from rangeface.simulate import _morphable

    monkeypatch.setattr(_morphable, "_LIMIT_BYTES", 10)
    write(tmp_path / "FaceXModel", "generic_neutral_mesh.obj", MESH)
    with pytest.raises(ScanError) as caught:
        simulate.ict_facekit(tmp_path)
    assert caught.value.fault is ScanFault.TOO_LARGE


def test_a_broken_npz_is_no_model(tmp_path):
    path = tmp_path / "model.npz"
    np.savez(path, mean=np.zeros((3, 3)))
    with pytest.raises(ScanError) as caught:
        simulate.ict_facekit(path)
    assert caught.value.fault is ScanFault.MALFORMED


# ── sensors ──────────────────────────────────────────────────────────────────────────────


def test_an_unknown_preset_lists_the_known():
    with pytest.raises(ParameterError, match=r"sensor.*sr3000"):
        sensors.preset("sr9000")


def test_an_unknown_effect_lists_the_known():
    with pytest.raises(ParameterError, match=r"effects.*wiggling"):
        sensors.preset("sr3000").without("gravity")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("principle", "sonar"),
        ("frequencies_hz", ()),
        ("frequencies_hz", (0.0,)),
        ("phases", 2),
        ("signal", 0.0),
        ("full_well", -1.0),
        ("scattering_px", 0.0),
        ("contrast", 0.0),
        ("contrast", 1.5),
        ("multipath", -0.1),
        ("scattering", 2.0),
        ("dead_pixels", 1.1),
        ("compression", 1.1),
        ("read_noise", -1.0),
        ("background", float("nan")),
        ("jitter_rad", -1e-3),
        ("vignetting", -4.0),
        ("quadratic_per_mm", -1.0),
    ],
)
def test_a_sensor_that_cannot_be(name, value):
    with pytest.raises(ParameterError, match=name):
        replace(sensors.preset("sr3000"), **{name: value})


@pytest.mark.parametrize("focal", [0.0, -5.0, float("nan")])
def test_a_camera_without_focal_length(focal):
    camera = sensors.preset("sr3000").camera
    with pytest.raises(ParameterError, match="fx"):
        SensorModel("bad", "a test", replace(camera, fx=focal))


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"views": ["backwards"]}, "views"),
        ({"distance_mm": 0.0}, "distance_mm"),
        ({"unrest_deg": -1.0}, "unrest_deg"),
        ({"workers": 0}, "workers"),
        ({"seed": -1}, "seed"),
    ],
)
def test_a_collection_is_refused_before_its_first_capture(options, name):
    with pytest.raises(ParameterError, match=name):
        simulate.collection([0], sensors.preset("sr3000"), **options)


def test_no_frame_at_all_is_refused():
    with pytest.raises(ParameterError, match="count"):
        simulate.frames(SCENE, sensors.preset("sr3000"), 0, rng=RNG)
