"""`evaluate --detail --against` and `explain` as a user meets them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface import config, describe, io
from rangeface.classify import PCA, SurfaceMatcher
from rangeface.evaluation.experiments import non_faces
from rangeface.evaluation.experiments.sources import source
from rangeface.gallery import MemoryGallery
from rangeface.pipeline import Head, step
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Verdict

PEOPLE = range(70, 80)


@pytest.fixture(scope="module")
def recognizer() -> FaceRecognizer:
    heads = (
        Head(step(describe.surface), SurfaceMatcher()),
        Head(step(describe.normals), PCA(20)),
        Head(step(describe.hog), PCA(20)),
    )
    way = replace(config.load_pipeline("fusion-3d"), heads=heads, augment_deg=(3.0,))
    images = [sr3000_face(p)[0] for p in range(90, 100)]
    names = [str(p) for p in range(90, 100)]
    fitted = FaceRecognizer.fit(way, images, names)
    return fitted.calibrate([fitted.template(image) for image in images], names)


@pytest.fixture(scope="module")
def model(recognizer, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("model") / "small.model"
    recognizer.save(path)
    return path


def test_evaluating_a_model_in_detail_says_what_each_head_adds(rangeface, folder, model, tmp_path):
    target = tmp_path / "out.json"
    status, out, _ = rangeface(
        "evaluate", "folder", folder, "--model", model, "--detail", "--against", "full-n-mlda",
        "--json", target,
    )  # fmt: skip
    assert status == 0
    result = json.loads(target.read_text())
    assert set(result["fusion"]) >= {
        "as shipped", "weights cross-validated over people", "without hog + PCA",
        "only surface + SurfaceMatcher",
    }  # fmt: skip
    assert result["fusion"]["as shipped"]["all"]["rank1"]["rate"] >= 0.9
    assert 0 <= result["paired"]["all"]["p"] <= 1
    assert "McNemar" in out


def test_evaluating_a_model_says_what_its_thresholds_are_worth(
    rangeface, folder, model, tmp_path, monkeypatch
):
    monkeypatch.setattr("rangeface.app.evaluate._PROMISED", (0.1, 0.001))
    target = tmp_path / "out.json"
    status, out, _ = rangeface("evaluate", "folder", folder, "--model", model, "--json", target)
    assert status == 0
    found = json.loads(target.read_text())["at_calibrated_fmr"]
    assert list(found) == ["0.1"]  # ten people cannot show 0.1 %
    assert "for an FMR of 10 %" in out
    assert found["0.1"]["fmr"] in out


def test_a_model_and_a_pipeline_at_once_are_refused(rangeface, folder, model):
    status, _, err = rangeface(
        "evaluate", "folder", folder, "--model", model, "--pipeline", "default"
    )
    assert (status, "give one of them" in err) == (2, True)


def test_explain_names_the_regions_that_speak_for_and_against(rangeface, folder, model, tmp_path):
    gallery, picture = tmp_path / "door.db", tmp_path / "why.png"
    options = ("--gallery", gallery, "--model", model)
    for person in (70, 71, 72):
        rangeface("enroll", person, folder / f"{person}-gallery.npz", *options)
    status, out, _ = rangeface(
        "explain", folder / "71-probe.npz", *options, "--fmr", 0.2, "--out", picture
    )
    assert status == 0
    assert "accepted 71" in out
    for region in ("forehead", "nose bridge", "left cheek", "mouth"):
        assert region in out
    drawn = cv2.imdecode(np.frombuffer(picture.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
    assert drawn.std() > 20
    mine = [float(line.split("│")[-2].split()[0]) for line in out.splitlines() if "nose" in line]
    _, out, _ = rangeface(
        "explain", folder / "71-probe.npz", *options, "--subject", 72, "--fmr", 0.2,
        "--out", picture,
    )  # fmt: skip
    theirs = [float(line.split("│")[-2].split()[0]) for line in out.splitlines() if "nose" in line]
    assert sum(mine) > sum(theirs)


def test_explaining_needs_somebody_and_surfaces(rangeface, folder, model, tmp_path):
    gallery = tmp_path / "door.db"
    options = ("--gallery", gallery, "--model", model)
    rangeface("enroll", 70, folder / "70-gallery.npz", *options)
    image = sr3000_face(70)[0]
    io.write_scan(tmp_path / "wall.npz", image.with_depth(np.full(image.shape, 500.0)))
    status, out, _ = rangeface("explain", tmp_path / "wall.npz", *options, "--fmr", 0.2)
    assert (status, "nothing to explain" in out) == (1, True)
    status, _, err = rangeface(
        "explain", folder / "70-probe.npz", *options, "--subject", "nobody", "--fmr", 0.2
    )
    assert (status, "'nobody' is not enrolled" in err) == (2, True)


@pytest.mark.parametrize("kind", non_faces.kinds(source(persons=2)))
def test_a_non_face_is_refused_with_a_reason(recognizer, kind):
    gallery = MemoryGallery()
    for person in (70, 71, 72):
        gallery.enroll(str(person), recognizer.template(sr3000_face(person)[0], augment=True))
    scene = non_faces.kinds(source(persons=2))[kind]
    answers = [
        recognizer.identify(scene(np.random.default_rng(k)), gallery, fmr=0.04) for k in range(10)
    ]
    accepted = sum(answer.verdict is Verdict.ACCEPTED for answer in answers)
    assert accepted <= (3 if kind == "half faces" else 0)  # half a face has half a chance here
    assert all(a.reason is not None for a in answers if a.verdict is not Verdict.ACCEPTED)
