"""The live recogniser before the synthetic camera: names, strangers, faults, two cameras."""

import time
from dataclasses import replace

import numpy as np
import pytest

from rangeface import sources
from rangeface.app.models import load_model
from rangeface.errors import SourceError
from rangeface.gallery import MemoryGallery
from rangeface.live import LiveRecognizer
from rangeface.sources import Faults, Faulty, Newest, Reconnecting, SyntheticCamera, Walk
from rangeface.types import Verdict

SENSOR = "sr3000"
#: Enrolled; a stranger.
KNOWN, STRANGER = 0, 900


def walks(stay_s=4.2):
    outside = (0.0, 0.0, 450.0)
    return [
        Walk(who, 0.0, stay_s, (x, 0.0, 450.0), (2 * x, *outside[1:]), (2 * x, *outside[1:]), 0.6)
        for who, x in ((KNOWN, -115.0), (STRANGER, 115.0))
    ]


def camera(**changes):
    return SyntheticCamera(SENSOR, walks(), rate_hz=15.0, repeat=False, keep=False, **changes)


@pytest.fixture(scope="module")
def recognizer():
    return load_model(None)


@pytest.fixture(scope="module")
def gallery(recognizer):
    people = MemoryGallery()
    for person in (KNOWN, 1, 2, 3):
        images = sources.enrolment(SENSOR, person)
        people.enroll(f"person {person}", recognizer.template(images, augment=True))
    return people


@pytest.fixture(scope="module")
def frames():
    return list(camera())


def live_on(recognizer, gallery, **options):
    return LiveRecognizer(recognizer, gallery, background=False, look_every=3, **options)


@pytest.fixture(scope="module")
def answers(recognizer, gallery, frames):
    with live_on(recognizer, gallery) as live:
        shown = [live.update(replace(f, arrived_s=time.monotonic())) for f in frames]
        live.finish()
    return shown, live


def tracked(answer, true):
    """The track under a person, by the truth."""
    where = true.pose.translation
    near = [t for t in answer.tracks if np.linalg.norm(where - t.nose_tip_mm) < 60.0]
    return near[0] if near else None


def test_the_known_person_is_named_and_the_stranger_is_not(answers, frames):
    shown, _ = answers
    named = {KNOWN: set(), STRANGER: set()}
    for answer, frame in zip(shown, frames, strict=True):
        for true in frame.truth:
            track = tracked(answer, true)
            if track is not None and track.verdict is Verdict.ACCEPTED:
                named[true.person].add(track.subject)
    assert named == {KNOWN: {"person 0"}, STRANGER: set()}


def test_both_are_followed_most_of_the_time(answers, frames):
    shown, _ = answers
    middle = [(a, f) for a, f in zip(shown, frames, strict=True) if 1.5 < f.time_s < 3.4]
    followed = [tracked(a, true) is not None for a, f in middle for true in f.truth]
    assert np.mean(followed) > 0.8


def test_poses_are_those_of_the_heads(answers, frames):
    shown, _ = answers
    errors = []
    for answer, frame in zip(shown, frames, strict=True):
        for true in frame.truth:
            track = tracked(answer, true)
            if track is not None and track.lost_s == 0.0:
                yaw, _, _ = np.rad2deg(true.pose.inverse().head_angles)
                errors.append(abs(yaw - track.yaw_deg))
    assert np.median(errors) < 5.0


def test_evidence_grows_with_time_and_is_shown(answers):
    shown, _ = answers
    track = next(t for a in reversed(shown) for t in a.tracks if t.subject)
    times = [time_s for time_s, _ in track.evidence]
    assert times == sorted(times)
    assert track.looks >= len(track.evidence) >= 1
    assert track.refuse_at < 0.0 < track.threshold <= track.score


def test_visits_end_with_their_people(answers):
    _, live = answers
    assert {v.subject for v in live.visits} == {"person 0", None}
    assert len({v.person for v in live.visits}) == len(live.people) == 2
    assert all(v.stop_s > v.start_s for v in live.visits)


def test_the_same_frames_give_the_same_answers(recognizer, gallery, frames, answers):
    shown, _ = answers
    with live_on(recognizer, gallery) as live:
        again = [live.update(replace(f, arrived_s=time.monotonic())) for f in frames[:30]]
    for one, other in zip(shown, again, strict=False):
        assert one.tracks == other.tracks


def test_a_deleted_person_is_not_known_any_more(recognizer, gallery, frames):
    people = MemoryGallery()
    for subject in gallery.subjects():
        name = "ann" if subject == "person 0" else subject
        people.enroll(name, gallery.templates(subject)[0])
    with live_on(recognizer, people, relook_s=0.1) as live:
        subjects = []
        for frame in frames[:48]:
            answer = live.update(replace(frame, arrived_s=time.monotonic()))
            subjects.append({t.subject for t in answer.tracks} - {None})
            if subjects[-1] and "ann" in people.subjects():
                people.delete("ann")
                deleted = len(subjects)
    assert any(subjects)
    assert not any(subjects[deleted + 8 :])


def test_old_doubled_and_late_frames_decide_nothing(recognizer, gallery, frames):
    with live_on(recognizer, gallery) as live:
        for frame in frames[:12]:
            live.update(replace(frame, arrived_s=time.monotonic()))
        before = live.update(replace(frames[12], arrived_s=time.monotonic()))
        for bad in (
            replace(frames[13], arrived_s=time.monotonic() - 1.5),
            replace(frames[12], arrived_s=time.monotonic()),
            replace(frames[5], arrived_s=time.monotonic()),
        ):
            answer = live.update(bad)
            assert answer.stale
            assert [t.looks for t in answer.tracks] == [t.looks for t in before.tracks]
        assert answer.ignored == 3
        assert not live.update(replace(frames[13], arrived_s=time.monotonic())).stale


@pytest.mark.parametrize("seed", range(2))
def test_faulty_frames_do_no_harm(recognizer, gallery, frames, seed):
    faults = Faults(drop=0.3, double=0.3, reorder=0.3, corrupt=0.3)

    class Again(sources._protocol.Closing):
        name, rate_hz = "again", 15.0

        def __iter__(self):
            return (replace(f, arrived_s=time.monotonic()) for f in frames)

    with live_on(recognizer, gallery) as live:
        for frame in Faulty(Again(), faults, seed=seed):
            answer = live.update(replace(frame, arrived_s=time.monotonic()))
            assert {t.subject for t in answer.tracks} <= {None, "person 0"}
    assert answer.ignored > 0


@pytest.mark.slow
def test_a_stall_and_a_hundred_reconnects(recognizer, gallery):
    opened = []

    def opener():
        k = len(opened)
        opened.append(k)
        good = SyntheticCamera(SENSOR, walks(), rate_hz=15.0, keep=False, repeat=False, seed=k)
        faults = Faults(break_at=(2,) if k < 100 else (), stall_at=(20,) if k == 100 else (),
                        stall_s=5.0)  # fmt: skip
        return Faulty(sources.Player(good, speed=1.0 if k >= 100 else None), faults)

    source = Reconnecting(opener, wait_s=0.01, max_wait_s=0.02)
    last_s, back_s, before = None, None, {}
    with LiveRecognizer(recognizer, gallery) as live, Newest(source) as newest:
        for frame in newest:
            answer = live.update(frame)
            now = time.monotonic()
            if last_s is not None and now - last_s > 4.0:
                back_s = now
            if back_s is not None and answer.tracks:
                found_s = now
                break
            last_s = now
            looks = {t.number: t.looks for t in answer.tracks}
            if answer.latency_ms > 1500.0:  # on a busy computer: the look came to nothing
                assert all(before.get(number, 0) == count for number, count in looks.items())
            before = looks
    assert source.reconnects == 100
    assert found_s - back_s < 2.0


def test_a_source_that_is_gone_says_so(recognizer, gallery):
    def opener():
        raise SourceError("realsense:0: 0 RealSense cameras are plugged in")

    source = Newest(Reconnecting(opener, patience_s=0.05, wait_s=0.01))
    with source, pytest.raises(SourceError, match="plugged in"):
        list(source)
