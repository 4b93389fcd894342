"""Enrolling from the live view: every side is asked for, and only good looks count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.conftest import sr3000_face

from rangeface.app.models import load_model
from rangeface.app.viewing.enrolment import Enrolment
from rangeface.gallery import MemoryGallery
from rangeface.types import Reason


@pytest.fixture(scope="module")
def recognizer():
    return load_model(None)


@pytest.fixture(scope="module")
def look(recognizer):
    trace = recognizer.pipeline.trace(sr3000_face(3)[0])
    assert trace.assessment is not None
    return trace


def turned(look, yaw_deg):
    return replace(look, assessment=replace(look.assessment, yaw_deg=yaw_deg, refusals=()))


def test_it_asks_for_every_side_and_is_complete_when_all_were_seen(look):
    enrolment = Enrolment("Eva", 1)
    hints = []
    for yaw_deg in [0.0] * 4 + [12.0] * 4 + [-12.0] * 4:
        assert not enrolment.complete
        enrolment.take(turned(look, yaw_deg))
        hints.append(enrolment.hint)
    assert enrolment.complete
    assert hints[2] == "Look straight ahead"
    assert hints[3] == "Turn a little to your left"
    assert hints[7] == "Turn a little to your right"
    assert [step["done"] for step in enrolment.as_dict()["steps"]] == [4, 4, 4]


def test_the_sides_may_come_in_any_order_and_too_far_a_turn_does_not_count(look):
    enrolment = Enrolment("Eva", 1)
    for yaw_deg in (12.0, 40.0, -40.0):
        enrolment.take(turned(look, yaw_deg))
    assert [step["done"] for step in enrolment.as_dict()["steps"]] == [0, 1, 0]
    assert not enrolment.sufficient


@pytest.mark.parametrize(
    ("reason", "hint"),
    [(Reason.TOO_NOISY, "Come closer"), (Reason.LOW_OVERLAP, "Show your whole face")],
)
def test_a_bad_look_does_not_count_and_says_what_to_do(look, reason, hint):
    enrolment = Enrolment("Eva", 1)
    enrolment.take(replace(look, assessment=replace(look.assessment, refusals=(reason,))))
    assert enrolment.hint == hint
    assert sum(step["done"] for step in enrolment.as_dict()["steps"]) == 0


def test_who_is_gone_is_asked_to_come_back():
    enrolment = Enrolment("Eva", 1)
    enrolment.take(None)
    assert enrolment.hint == "Come back into view"


def test_the_template_is_the_mean_of_the_looks_and_knows_the_person(recognizer, look):
    enrolment = Enrolment("Eva", 1)
    for yaw_deg in [0.0] * 4 + [12.0] * 2:
        enrolment.take(turned(look, yaw_deg))
    template = enrolment.template(recognizer)
    ahead = recognizer.template(look, augment=True).vectors[0]
    np.testing.assert_allclose(template.vectors[0][: len(ahead)], ahead, rtol=1e-4, atol=1e-5)
    assert len(template.vectors[0]) == len(ahead) + 1
    gallery = MemoryGallery()
    gallery.enroll("Eva", template)
    assert recognizer.identify(look, gallery).subject == "Eva"
