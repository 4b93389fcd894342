"""Steps check their parameters, fingerprints name what matters, configuration is a picture."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface import config, denoise, describe, segment
from rangeface.classify import MLDA, PCA
from rangeface.denoise import median
from rangeface.errors import NoFaceError, ParameterError
from rangeface.gallery import stack
from rangeface.pipeline import FacePipeline, Head, step
from rangeface.types import Reason

PEOPLE = (3, 4, 5)


@pytest.fixture(scope="module")
def pipeline() -> FacePipeline:
    return replace(config.load_pipeline("full-n-mlda"), augment_deg=(-3.0, 3.0))


@pytest.fixture(scope="module")
def fitted(pipeline: FacePipeline) -> FacePipeline:
    images = [sr3000_face(person)[0] for person in PEOPLE]
    return pipeline.fit(images, [f"person {p}" for p in PEOPLE])


def test_a_step_binds_its_parameters_and_can_be_compared_hashed_and_pickled() -> None:
    a, b = step(denoise.median, size_px=5), step(denoise.median, size_px=5)
    assert a == b
    assert hash(a) == hash(b)
    assert pickle.loads(pickle.dumps(a)) == a  # noqa: S301 our own bytes
    assert a != step(denoise.median, size_px=3)
    assert repr(a) == "median(size_px=5)"


def test_a_wrong_parameter_fails_where_it_is_written_and_names_the_right_ones() -> None:
    with pytest.raises(ParameterError, match=r"unknown parameter 'size'; it takes .*size_px"):
        step(denoise.median, size=5)


def test_a_pipeline_without_heads_is_refused(pipeline: FacePipeline) -> None:
    with pytest.raises(ParameterError, match="heads"):
        replace(pipeline, heads=())


def test_every_preset_loads_and_survives_the_round_trip_through_toml() -> None:
    for name in config.presets():
        way = config.load_pipeline(name)
        again = config.from_toml(config.to_toml(way))
        assert again.fingerprint == way.fingerprint, name


def test_code_and_toml_give_the_same_fingerprint(pipeline: FacePipeline) -> None:
    text = config.to_toml(pipeline)
    assert config.from_toml(text).fingerprint == pipeline.fingerprint


CHANGES = {
    "a parameter": lambda p: replace(p, segment=p.segment.with_params(radius_mm=100.0)),
    "a method": lambda p: replace(p, denoise=step(denoise.median)),
    "a classifier's parameter": lambda p: replace(
        p, heads=(Head(p.heads[0].describe, MLDA(alpha=2.0)),)
    ),
    "a feature": lambda p: replace(p, heads=(Head(step(describe.n3), p.heads[0].classify),)),
    "the augmentation": lambda p: replace(p, augment_deg=(1.0,)),
}


@pytest.mark.parametrize("change", CHANGES)
def test_the_fingerprint_changes_with(change: str, pipeline: FacePipeline) -> None:
    assert CHANGES[change](pipeline).fingerprint != pipeline.fingerprint


def test_writing_a_default_out_does_not_change_the_fingerprint(pipeline: FacePipeline) -> None:
    same = replace(pipeline, denoise=step(denoise.none), segment=step(segment.slices))
    assert same.fingerprint == replace(pipeline, denoise=step(denoise.none)).fingerprint


def test_fit_gives_a_new_pipeline_with_another_fingerprint(pipeline, fitted) -> None:
    assert fitted is not pipeline
    assert fitted.fingerprint != pipeline.fingerprint
    assert not hasattr(pipeline.heads[0].classify, "components_")


def test_everybody_is_nearest_to_themself_on_another_day(fitted: FacePipeline) -> None:
    gallery = stack(
        ((f"person {p}", fitted.template(sr3000_face(p)[0], augment=True)) for p in PEOPLE),
        fitted.fingerprint,
    )
    for k, person in enumerate(PEOPLE):
        probe = fitted.template(sr3000_face(person, session=1, noise=7)[0])
        assert fitted.similarity(probe, gallery).argmax() == k


def test_a_trace_holds_every_intermediate_and_its_time(fitted: FacePipeline) -> None:
    trace = fitted.trace(sr3000_face(3)[0])
    stages = {"denoise", "segment", "register", "frontal", "assess", "describe"}
    assert set(trace.times_ms) == stages
    assert trace.frontal.shape == (80, 50)
    assert len(trace.features) == len(fitted.heads)
    assert trace.reason is None


def test_a_trace_of_nothing_says_where_it_ended(fitted: FacePipeline) -> None:
    image = sr3000_face(3)[0]
    trace = fitted.trace(image.masked(np.zeros(image.shape, bool)))
    assert trace.frontal is None
    assert trace.reason is Reason.NO_VALID_PIXELS
    with pytest.raises(NoFaceError, match="no valid pixels"):
        fitted.template(trace)


def test_the_same_image_gives_the_same_template(fitted: FacePipeline) -> None:
    image = sr3000_face(4)[0]
    first, second = fitted.template(image), fitted.template(image)
    assert np.array_equal(first.vectors[0], second.vectors[0])


def test_templates_of_another_pipeline_do_not_compare(fitted: FacePipeline) -> None:
    other = replace(fitted, augment_deg=())
    probe = other.template(sr3000_face(3)[0])
    gallery = stack([("a", fitted.template(sr3000_face(3)[0]))], fitted.fingerprint)
    with pytest.raises(ParameterError, match="enrol again"):
        fitted.similarity(probe, gallery)


def test_fusing_two_heads_runs_the_way_once(pipeline: FacePipeline) -> None:
    heads = (Head(step(describe.depth), PCA()), Head(step(describe.n3), PCA()))
    way = replace(pipeline, heads=heads)
    fitted = way.fit([sr3000_face(p)[0] for p in PEOPLE], list("abc"))
    template = fitted.template(sr3000_face(4)[0])
    assert len(template.vectors) == 2


BROKEN = {
    "broken TOML": ("combine = ", "broken TOML"),
    "an unknown slot": ('smooth = { method = "none" }', "unknown slot 'smooth'; known: combine"),
    "an unknown method": ('denoise = { method = "magic" }', "denoise: unknown method 'magic'"),
    "a missing slot": ("", "denoise: write denoise = "),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_mistake_in_a_configuration_names_the_slot(name: str) -> None:
    text, message = BROKEN[name]
    with pytest.raises(ParameterError, match=message):
        config.from_toml(text)


def test_an_unknown_preset_lists_the_known_ones() -> None:
    with pytest.raises(ParameterError, match="full-n-mlda"):
        config.load_pipeline("nonsense")
    with pytest.raises(ParameterError, match="no such configuration file"):
        config.load_pipeline("nowhere.toml")


def test_a_noisier_view_has_the_noise_that_it_states(fitted: FacePipeline) -> None:
    trace = fitted.trace(sr3000_face(20)[0])
    noisy = replace(fitted, augment_deg=(), augment_noise=(1.0,)).views(trace)
    assert len(noisy) == 2
    plain, more = (view.depth - median(view).depth for view in noisy)
    assert 1.2 < np.nanstd(more) / np.nanstd(plain) < 2.5
    # depth moves points along their rays too: neighbours are others
    stated = np.nanmedian(noisy[1].sigma) / np.nanmedian(noisy[0].sigma)
    assert stated == pytest.approx(np.sqrt(2.0), rel=0.25)
    again = replace(fitted, augment_deg=(), augment_noise=(1.0,)).views(trace)
    np.testing.assert_array_equal(noisy[1].depth, again[1].depth)


def test_augmentation_is_a_list_of_numbers_in_a_configuration() -> None:
    text = config.to_toml(config.load_pipeline("full-n-mlda"))
    way = config.from_toml(text.replace("augment_noise = []", "augment_noise = [1, 3.0]"))
    assert way.augment_noise == (1.0, 3.0)
    for wrong in ("3.0", '["a"]', "[true]", "[-1.0]"):
        with pytest.raises(ParameterError, match="augment_noise"):
            config.from_toml(text.replace("augment_noise = []", f"augment_noise = {wrong}"))
