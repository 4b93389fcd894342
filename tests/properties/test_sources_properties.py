"""Hand-over, playing, faults and reconnecting: nothing is lost without being counted."""

import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rangeface.errors import SourceError
from rangeface.sources import Faults, Faulty, Frame, Newest, Player, Reconnecting
from rangeface.sources._protocol import Closing
from rangeface.types import Pinhole, RangeImage

IMAGE = RangeImage(np.full((4, 6), 500.0), Pinhole(20.0, 20.0, 2.5, 1.5, 6, 4))


class Listed(Closing):
    """Frames at once, each after the gate has opened."""

    name, rate_hz = "listed", 30.0

    def __init__(self, count, *, breaks=False, gate=None):
        self.count, self.breaks, self.gate = count, breaks, gate
        self.closed = 0

    def __iter__(self):
        for k in range(self.count):
            if self.gate is not None:
                self.gate.wait(5.0)
            yield Frame(IMAGE, k / 30.0, k)
        if self.breaks:
            raise SourceError("listed: unplugged")

    def close(self):
        self.closed += 1


@given(count=st.integers(0, 30), capacity=st.integers(1, 5))
def test_every_frame_is_handed_over_or_counted_as_dropped(count, capacity):
    newest = Newest(Listed(count), capacity=capacity)
    numbers, dropped = [], 0
    for frame in newest:
        numbers.append(frame.number)
        dropped = frame.dropped
    assert len(numbers) + newest.dropped == count
    assert numbers == sorted(set(numbers))
    assert dropped <= newest.dropped
    assert numbers[-1:] == [count - 1] * bool(count)  # the newest one wins


def test_a_slow_reader_gets_the_newest_frames():
    newest = Newest(Listed(50), capacity=2)
    stream = iter(newest)
    first = next(stream).number
    newest._thread.join(5.0)
    assert [first, *(frame.number for frame in stream)][-2:] == [48, 49]


def test_a_failure_comes_after_the_frames_before_it():
    stream = iter(Newest(Listed(2, breaks=True), capacity=9))
    assert [next(stream).number, next(stream).number] == [0, 1]
    with pytest.raises(SourceError, match="unplugged"):
        next(stream)


def test_closing_wakes_a_waiting_reader():
    gate = threading.Event()
    newest = Newest(Listed(3, gate=gate))
    threading.Timer(0.05, lambda: (gate.set(), newest.close())).start()
    assert len(list(newest)) <= 3
    newest.close()


def test_a_paused_player_gives_a_frame_a_step():
    player = Player(Listed(5), playing=False)
    stream = iter(player)
    for expected in range(3):
        player.step()
        assert next(stream).number == expected
    assert not player.playing
    player.play()
    assert [frame.number for frame in stream] == [3, 4]


def test_a_closed_player_ends():
    player = Player(Listed(5), playing=False)
    threading.Timer(0.05, player.close).start()
    assert list(player) == []


def test_a_player_keeps_the_recorded_time():
    start = time.monotonic()
    arrived = [frame.arrived_s for frame in Player(Listed(4), speed=2.0)]
    assert time.monotonic() - start >= 3 / 60
    assert np.all(np.diff(arrived) > 0)


@given(seed=st.integers(0, 99))
def test_without_faults_nothing_changes(seed):
    frames = list(Faulty(Listed(9), Faults(), seed=seed))
    assert [frame.number for frame in frames] == list(range(9))
    assert all(frame.image is IMAGE for frame in frames)


@given(seed=st.integers(0, 99))
def test_faults_are_the_same_for_the_same_seed(seed):
    faults = Faults(drop=0.3, double=0.3, reorder=0.3, corrupt=0.3)
    runs = [[f.number for f in Faulty(Listed(30), faults, seed=seed)] for _ in range(2)]
    assert runs[0] == runs[1]


def test_all_kinds_of_faults_happen():
    faults = Faults(drop=0.3, double=0.3, reorder=0.3, corrupt=0.3)
    frames = list(Faulty(Listed(200), faults, seed=1))
    numbers = [frame.number for frame in frames]
    assert len(set(numbers)) < 200
    assert len(numbers) > len(set(numbers))
    assert numbers != sorted(numbers)
    assert any(frame.image.shape != IMAGE.shape for frame in frames)
    assert any(not frame.image.mask.any() for frame in frames)


def test_a_hundred_reconnects_lose_no_order():
    opened = []

    def opener():
        opened.append(Listed(3, breaks=len(opened) < 100))
        return opened[-1]

    source = Reconnecting(opener, wait_s=1e-4, max_wait_s=1e-3)
    frames = list(source)
    assert source.reconnects == 100
    assert [frame.number for frame in frames] == list(range(303))
    assert np.all(np.diff([frame.time_s for frame in frames]) > 0)
    assert all(listed.closed for listed in opened)


def test_a_source_that_stays_away_is_given_up_with_its_own_words():
    def opener():
        raise SourceError("realsense:0: 0 cameras are plugged in")

    with pytest.raises(SourceError, match="0 cameras"):
        list(Reconnecting(opener, patience_s=0.05, wait_s=0.01))


def test_closing_ends_the_wait_for_a_source():
    def opener():
        raise SourceError("away")

    source = Reconnecting(opener, wait_s=5.0)
    threading.Timer(0.05, source.close).start()
    start = time.monotonic()
    assert list(source) == []
    assert time.monotonic() - start < 4.0
