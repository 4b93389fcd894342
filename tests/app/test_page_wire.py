"""Frames on their way to the page: nothing is lost in packing, nothing piles up."""

from __future__ import annotations

import asyncio
import json

import numpy as np
import pytest

from rangeface.app.viewing.audience import Audience, Seat
from rangeface.app.viewing.wire import Plane, encode


def unpack(message: bytes) -> tuple[dict, list[np.ndarray]]:
    """What `protocol.ts` does, less the count of missed frames."""
    length = int.from_bytes(message[:4], "little")
    head, offset, planes = json.loads(message[4 : 4 + length]), 4 + length, []
    for plane in head["planes"]:
        count = plane["rows"] * plane["cols"]
        values = np.frombuffer(message, "<u2", count, offset).reshape(plane["rows"], plane["cols"])
        depth = plane["offset_mm"] + plane["step_mm"] * values
        planes.append(np.where(values > 0, depth, np.nan))
        offset += -(-2 * count // 4) * 4
    assert offset == len(message)
    return head, planes


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (144, 176)])
def test_depth_survives_to_half_a_step(shape):
    rng = np.random.default_rng(0)
    depth = rng.uniform(300, 2000, shape).astype(np.float32)
    depth[rng.random(shape) < 0.3] = np.nan
    surface = np.full((2, 3), -4.25, np.float32)
    head, planes = unpack(
        encode({"frame": 7, "who": "Zoë"}, [Plane("depth", depth, 0.25, {}),
                                            Plane("surface", surface, 0.05, {"track": 2})])
    )  # fmt: skip
    assert (head["frame"], head["who"]) == (7, "Zoë")
    assert head["planes"][1]["track"] == 2
    assert np.array_equal(np.isnan(planes[0]), np.isnan(depth))
    np.testing.assert_allclose(planes[0], depth, atol=0.126)
    np.testing.assert_allclose(planes[1], surface, atol=0.026)


def test_an_empty_frame_is_all_invalid():
    _, (plane,) = unpack(encode({}, [Plane("depth", np.full((4, 4), np.nan, np.float32), 1.0, {})]))
    assert np.isnan(plane).all()


def test_what_is_too_far_for_the_levels_is_left_out():
    depth = np.array([[100.0, 100.0 + 70_000.0]], np.float32)
    _, (plane,) = unpack(encode({}, [Plane("depth", depth, 1.0, {})]))
    assert plane[0, 0] == 100.0
    assert np.isnan(plane[0, 1])


def test_a_slow_page_gets_the_newest_frame_and_the_count_of_the_others():
    async def scene():
        seat = Seat()
        for number in range(1, 11):
            seat.offer(number, b"%d" % number)
        first = await seat.next()
        seat.offer(11, b"11")
        second = await seat.next()
        seat.offer(12, b"12")
        seat.offer(13, b"13")
        with pytest.raises(TimeoutError):  # two are on their way: it has to show them first
            await asyncio.wait_for(seat.next(), 0.05)
        seat.seen(11)
        return first, second, await seat.next()

    first, second, third = asyncio.run(scene())
    assert (first[4:], int.from_bytes(first[:4], "little")) == (b"10", 9)
    assert second[4:] == b"11"
    assert (third[4:], int.from_bytes(third[:4], "little")) == (b"13", 10)


def test_replies_and_the_newest_state_come_before_frames():
    async def scene():
        seat = Seat()
        seat.offer(1, b"frame")
        seat.tell("old")
        seat.tell("new")
        seat.reply("reply")
        return [await seat.next() for _ in range(3)]

    assert asyncio.run(scene()) == ["reply", "new", b"\0\0\0\0frame"]


def test_who_asks_without_reading_is_let_go():
    async def scene():
        seat = Seat()
        for _ in range(1000):
            seat.reply("x")

    with pytest.raises(ConnectionError):
        asyncio.run(scene())


def test_an_audience_is_shown_frames_from_another_thread():
    async def scene():
        audience, seat = Audience(), Seat()
        audience.join(seat)
        await asyncio.to_thread(audience.show, 3, b"three")
        message = await asyncio.wait_for(seat.next(), 5)
        audience.leave(seat)
        await asyncio.to_thread(audience.show, 4, b"four")
        return message, len(audience)

    assert asyncio.run(scene()) == (b"\0\0\0\0three", 0)
