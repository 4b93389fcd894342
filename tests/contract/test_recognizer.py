"""A recogniser decides, survives its file, and notices every damage to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface import config
from rangeface.errors import GalleryError, ParameterError, ScanError
from rangeface.gallery import MemoryGallery
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Reason, Verdict

PEOPLE = tuple(range(20, 32))


@pytest.fixture(scope="module")
def recognizer() -> FaceRecognizer:
    pipeline = replace(config.load_pipeline("full-n-mlda"), augment_deg=(-3.0, 3.0))
    images = [sr3000_face(p)[0] for p in PEOPLE]
    fitted = FaceRecognizer.fit(pipeline, images, [str(p) for p in PEOPLE])
    others = range(40, 48)
    templates = [fitted.template(sr3000_face(p)[0]) for p in others]
    return fitted.calibrate(templates, [str(p) for p in others])


@pytest.fixture(scope="module")
def gallery(recognizer: FaceRecognizer) -> MemoryGallery:
    gallery = MemoryGallery()
    for person in (60, 61, 62):
        template = recognizer.template(sr3000_face(person)[0], augment=True)
        gallery.enroll(str(person), template)
    return gallery


def test_a_friend_ranks_first_and_verifies(recognizer, gallery) -> None:
    image = sr3000_face(61, session=1, noise=3)[0]
    decision = recognizer.identify(image, gallery, fmr=0.2)
    assert decision.ranking[0][0] == "61"
    assert recognizer.verify(image, "61", gallery, fmr=0.2).verdict is Verdict.ACCEPTED


def test_an_image_without_a_face_is_answered_with_cannot_tell(recognizer, gallery) -> None:
    image = sr3000_face(61)[0]
    nothing = image.masked(np.zeros(image.shape, bool))
    for decision in (
        recognizer.identify(nothing, gallery, fmr=0.2),
        recognizer.verify(nothing, "61", gallery, fmr=0.2),
    ):
        assert decision.verdict is Verdict.CANNOT_TELL
        assert decision.reason is Reason.NO_VALID_PIXELS


def test_an_empty_gallery_knows_nobody(recognizer: FaceRecognizer) -> None:
    decision = recognizer.identify(sr3000_face(61)[0], MemoryGallery(), fmr=0.2)
    assert decision.verdict is Verdict.UNKNOWN
    assert decision.reason is Reason.EMPTY_GALLERY


def test_a_threshold_that_the_calibration_cannot_show_is_refused(recognizer, gallery) -> None:
    with pytest.raises(ParameterError, match="cannot be shown"):
        recognizer.identify(sr3000_face(61)[0], gallery, fmr=1e-6)
    with pytest.raises(ParameterError, match="not calibrated"):
        replace(recognizer, nonmated=np.empty(0, np.float32)).threshold(0.1)


def test_verifying_against_nobody_is_an_error(recognizer, gallery) -> None:
    with pytest.raises(GalleryError, match="'nobody' is not enrolled"):
        recognizer.verify(sr3000_face(61)[0], "nobody", gallery, fmr=0.2)


def test_a_saved_recogniser_decides_the_same(recognizer, gallery, tmp_path) -> None:
    recognizer.save(tmp_path / "m.model")
    loaded = FaceRecognizer.load(tmp_path / "m.model")
    assert loaded.pipeline.fingerprint == recognizer.pipeline.fingerprint
    image = sr3000_face(62, session=1)[0]
    assert loaded.identify(image, gallery, fmr=0.2) == recognizer.identify(image, gallery, fmr=0.2)
    assert loaded.provenance["people"] == len(PEOPLE)


def test_every_flipped_byte_and_every_cut_of_a_model_file_is_noticed(recognizer, tmp_path) -> None:
    path = tmp_path / "m.model"
    recognizer.save(path)
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    for position in rng.integers(0, len(whole), 40):
        broken = bytearray(whole)
        broken[position] ^= 0x10
        path.write_bytes(broken)
        with pytest.raises(ScanError, match=r"m\.model"):
            FaceRecognizer.load(path)
    for part in range(64):
        path.write_bytes(whole[: len(whole) * part // 64])
        with pytest.raises(ScanError, match=r"m\.model"):
            FaceRecognizer.load(path)


def test_a_missing_model_is_one_clear_line(tmp_path) -> None:
    with pytest.raises(ScanError, match="file not found"):
        FaceRecognizer.load(tmp_path / "none.model")
