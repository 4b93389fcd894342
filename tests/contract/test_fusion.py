"""Fused heads: one scale, missing amplitudes, small files, calibration without re-enrolment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface import config, describe, register
from rangeface.classify import Direct, RegularizedLDA, fitted_state
from rangeface.errors import DegenerateError, ParameterError
from rangeface.gallery import MemoryGallery, open_gallery, stack
from rangeface.io.arrays import read_arrays, write_arrays
from rangeface.pipeline import FacePipeline, Head, step
from rangeface.recognizer import FaceRecognizer, default_recognizer, with_shipped_heads

PEOPLE = tuple(range(70, 76))


@pytest.fixture(scope="module")
def images():
    return {(p, s): sr3000_face(p, session=s, noise=s)[0] for p in PEOPLE for s in (0, 1)}


@pytest.fixture(scope="module")
def recognizer(images) -> FaceRecognizer:
    heads = (
        Head(step(describe.normals), RegularizedLDA(shrinkage=0.5)),
        Head(step(describe.depth), Direct()),
        Head(step(describe.albedo), RegularizedLDA(shrinkage=0.5)),
    )
    pipeline = replace(config.load_pipeline("fusion-3d-ir"), heads=heads, augment_deg=(3.0,))
    return FaceRecognizer.fit(pipeline, list(images.values()), [str(p) for p, _ in images])


def without_amplitude(image):
    return replace(image, amplitude=None)


def test_the_default_is_fusion_3d():
    default, fused = config.load_pipeline("default"), config.load_pipeline("fusion-3d")
    assert default.fingerprint == fused.fingerprint
    assert len(config.load_pipeline("fusion-3d-ir").heads) == len(fused.heads) + 1


def test_the_infrared_preset_learns_only_its_infrared_head(images):
    way = config.load_pipeline("fusion-3d-ir")
    shown, names = list(images.values()), [str(person) for person, _ in images]
    learned = FaceRecognizer.fit(replace(way, augment_deg=()), shown, names).pipeline
    shipped = default_recognizer().pipeline
    for head, other in zip(learned.heads, shipped.heads, strict=False):
        assert head.classify is other.classify
    assert fitted_state(learned.heads[-1].classify)
    assert [head.shipped for head in learned.heads] == [True] * 5 + [False]


@pytest.mark.parametrize(
    "change",
    [
        {"heads": (Head(step(describe.normals), Direct(), shipped=True),)},
        {"frontal": step(register.frontal.resample, width_mm=100.0, height_mm=160.0)},
    ],
)
def test_a_shipped_head_that_the_model_does_not_have_is_refused(change):
    way = replace(config.load_pipeline("fusion-3d-ir"), **change)
    with pytest.raises(ParameterError, match="heads: the"):
        with_shipped_heads(way)
    with pytest.raises(ParameterError, match=r"learn with FaceRecognizer\.fit"):
        way.fit_views([[None]], ["anna"])


def test_heads_on_very_different_scales_are_fused_as_equals(recognizer, images):
    way = recognizer.pipeline
    references = stack(
        ((str(p), way.template(images[p, 0])) for p in PEOPLE), recognizer.pipeline.fingerprint
    )
    probe = way.template(images[72, 1])
    raw = way.head_scores(probe, references)
    assert raw.shape == (3, len(PEOPLE))
    assert np.abs(raw[1]).max() > 20 * np.abs(raw[0]).max()  # millimetres beside cosines
    fused = recognizer.scores(probe, references)
    normalised = way.normalise(raw, way.head_scores(probe, recognizer.cohort))
    np.testing.assert_allclose(fused, normalised.mean(axis=0), rtol=1e-5)
    assert fused.argmax() == PEOPLE.index(72)


def test_a_capture_without_amplitude_leaves_the_infrared_head_out(recognizer, images, tmp_path):
    way: FacePipeline = recognizer.pipeline
    dark = way.template(without_amplitude(images[71, 1]))
    assert dark.vectors[2].shape == (0, way.heads[2].classify.n_components_)
    references = stack(
        ((str(p), way.template(images[p, 0])) for p in PEOPLE), recognizer.pipeline.fingerprint
    )
    scores = way.head_scores(dark, references)
    assert np.isnan(scores[2]).all()
    assert np.isfinite(scores[:2]).all()
    assert recognizer.scores(dark, references).argmax() == PEOPLE.index(71)
    with open_gallery(str(tmp_path / "door.db")) as gallery:  # and such people can be enrolled
        gallery.enroll("71", dark)
        gallery.enroll("72", way.template(images[72, 0]))
        assert recognizer.scores(way.template(images[72, 1]), gallery.view()).argmax() == 1


def test_training_an_infrared_head_without_any_amplitude_is_refused(recognizer, images):
    way = recognizer.pipeline
    views = [way.views(way.trace(without_amplitude(images[p, 0]))) for p in PEOPLE[:2]]
    with pytest.raises(DegenerateError, match="albedo: no training capture has an amplitude"):
        way.fit_views(views, ["a", "b"])


def test_calibrating_keeps_templates_valid_and_takes_the_new_people_as_cohort(recognizer, images):
    way = recognizer.pipeline
    gallery = MemoryGallery()
    for p in PEOPLE[:3]:
        gallery.enroll(str(p), recognizer.template(images[p, 0], augment=True))
    others = [way.template(sr3000_face(p)[0]) for p in (80, 81, 82)]
    calibrated = recognizer.calibrate(others, ["80", "81", "82"])
    assert calibrated.pipeline.fingerprint == recognizer.pipeline.fingerprint
    assert calibrated.cohort.subjects == ("80", "81", "82")
    assert calibrated.nonmated.size == 6
    assert calibrated.identify(images[71, 1], gallery, fmr=0.5).ranking[0][0] == "71"


def test_a_saved_fusion_scores_the_same_from_half_the_bytes(recognizer, images, tmp_path):
    path = tmp_path / "fused.model"
    recognizer.save(path)
    loaded = FaceRecognizer.load(path)
    assert loaded.pipeline.fingerprint == recognizer.pipeline.fingerprint
    references = stack(
        ((str(p), recognizer.template(images[p, 0])) for p in PEOPLE),
        recognizer.pipeline.fingerprint,
    )
    probe = recognizer.template(images[73, 1])
    np.testing.assert_array_equal(
        loaded.scores(probe, references), recognizer.scores(probe, references)
    )
    assert path.read_bytes().count(b'"<f2"') >= 2  # both projections


def test_half_precision_is_kept_only_where_it_is_exact(tmp_path):
    rng = np.random.default_rng(0)
    exact = np.ldexp(rng.standard_normal((40, 30)).astype(np.float16).astype(np.float32), -9)
    arrays = {
        "exact": exact,
        "full": rng.standard_normal((40, 30)).astype(np.float32),
        "holes": np.where(exact > 0, exact, np.nan).astype(np.float32),
        "zero": np.zeros(3, np.float32),
        "none": np.empty((0, 4), np.float32),
    }
    write_arrays(tmp_path / "a", {}, arrays)
    _, back = read_arrays(tmp_path / "a")
    for name, array in arrays.items():
        assert back[name].dtype == np.float32
        np.testing.assert_array_equal(back[name], array)
    everything = sum(a.nbytes for a in arrays.values())
    assert (tmp_path / "a").stat().st_size < everything + 1500 - exact.nbytes // 2 + 200


def test_a_large_gallery_is_shortlisted_for_the_slow_head(images, monkeypatch):
    from rangeface.classify import SurfaceMatcher
    from rangeface.pipeline import _compare

    heads = (
        Head(step(describe.normals), RegularizedLDA(shrinkage=0.5)),
        Head(step(describe.surface), SurfaceMatcher()),
    )
    way = replace(config.load_pipeline("fusion-3d"), heads=heads, augment_deg=())
    way = way.fit(list(images.values()), [str(p) for p, _ in images])
    references = stack(((str(p), way.template(images[p, 0])) for p in PEOPLE), way.fingerprint)
    probe = way.template(images[72, 1])
    whole, full = way.head_scores(probe, references), way.similarity(probe, references)
    monkeypatch.setattr(_compare, "SHORTLIST", 3)
    few, short = way.head_scores(probe, references), way.similarity(probe, references)
    np.testing.assert_array_equal(few[0], whole[0])
    assert np.isfinite(few[1]).sum() == 3
    listed = np.isfinite(few[1])
    np.testing.assert_array_equal(few[1, listed], whole[1, listed])
    assert set(np.flatnonzero(listed)) == set(np.argsort(-whole[0])[:3])
    assert short[~listed].max() <= short[listed].min()
    assert short.argmax() == full.argmax() == PEOPLE.index(72)
