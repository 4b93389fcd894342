"""How well are people counted, and followed from one line to another, without a name?

Passengers walk past a camera on their line in groups of up to three, some of them twice; later
most of them walk past the camera of a second line, in other groups, with some who were not on
the first. Nobody is enrolled. Asked: how many different people passed, and who of the first line
is who of the second.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rangeface.evaluation.error_rates import Rate
from rangeface.gallery import MemoryGallery
from rangeface.live import Doorway, LiveFrame, LiveRecognizer, Transfer, count_people, link_people
from rangeface.recognizer import FaceRecognizer
from rangeface.sources import Frame, SyntheticCamera, Walk

SENSOR, RATE_HZ = "pmd-flexx2", 15.0
_DISTANCE_MM, _APART_MM, _OUTSIDE_MM = 650.0, 225.0, 760.0
_PASSAGE_S, _PAUSE_S = 3.6, 1.4
#: Numbers of heads that no model was trained on.
FIRST_PERSON = 700_000


@dataclass(frozen=True)
class Line:
    """What happened before one camera, and what the recogniser made of it.

    Parameters
    ----------
    live : LiveRecognizer
        After its source has ended.
    who : mapping of int to int
        Number of a remembered person → number of the head that it mostly was.
    passages : int
        True number of passages.
    """

    live: LiveRecognizer
    who: dict[int, int]
    passages: int


def run(
    recognizer: FaceRecognizer,
    *,
    seed: int = 0,
    passengers: int = 30,
    twice: int = 6,
    changing: int = 24,
    joining: int = 4,
) -> dict[str, Any]:
    """Let passengers walk by, count them, and link the two lines.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Calibrated.
    seed : int
        Of people, groups and noise.
    passengers : int
        Different people on the first line, ≥ 1.
    twice : int
        How many of them pass its camera twice.
    changing : int
        How many of them change to the second line.
    joining : int
        People on the second line who were not on the first.

    Returns
    -------
    dict
        Counts and the transfer table's correctness; JSON.
    """
    rng = np.random.default_rng(seed)
    people = FIRST_PERSON + 1000 * seed + np.arange(passengers + joining)
    first, newcomers = people[:passengers], people[passengers:]
    again = rng.permutation(first)[:twice]
    changed = rng.permutation(first)[:changing]
    order = [*rng.permutation(first).tolist(), *rng.permutation(again).tolist()]
    here = _watch(recognizer, _walks(order, rng), seed=2 * seed)
    later = rng.permutation(np.concatenate([changed, newcomers])).tolist()
    there = _watch(recognizer, _walks(later, rng), seed=2 * seed + 1)
    table = link_people(
        here.live.people.everybody(), there.live.people.everybody(), recognizer,
        threshold=here.live.people.threshold(len(there.live.people)),
    )  # fmt: skip
    right = sum(_is_right(int(p), p in changed, table, here, there) for p in first)
    counts = [count_people(line.live.visits, Doorway()) for line in (here, there)]
    return {
        "seed": seed,
        "passengers": passengers,
        "counted_different": counts[0].different,
        "passages": here.passages,
        "counted_in": counts[0].went_in,
        "second_line": len(later),
        "second_line_counted_different": counts[1].different,
        "not_told_apart": counts[0].nobody,
        "transfers_right": right,
        "transfers": str(Rate.of(right, passengers)),
        "links": sum(t.first is not None and t.second is not None for t in table),
        "true_links": changing,
    }


def _walks(order: Sequence[int], rng: np.random.Generator) -> list[Walk]:
    """People in that order, in groups of one to three abreast, from left to right."""
    walks, start, waiting = [], 0.0, list(order)
    while waiting:
        size = min(int(rng.integers(1, 4)), len(waiting))
        group, waiting = waiting[:size], waiting[size:]
        if len(set(group)) < size:  # nobody walks beside himself
            group, waiting = group[:1], [*group[1:], *waiting]
        for place, person in enumerate(group):
            x = _APART_MM * (place - 0.5 * (len(group) - 1))
            y, z = rng.uniform(-25.0, 25.0), _DISTANCE_MM + rng.uniform(-30.0, 30.0)
            walks.append(
                Walk(
                    int(person), start, start + _PASSAGE_S, (x, y, z),
                    (x - _OUTSIDE_MM, y, z), (x + _OUTSIDE_MM, y, z), stride_s=1.4,
                )
            )  # fmt: skip
        start += _PASSAGE_S + _PAUSE_S
    return walks


def _watch(recognizer: FaceRecognizer, walks: list[Walk], *, seed: int) -> Line:
    """Everything that happens before one camera."""
    camera = SyntheticCamera(SENSOR, walks, rate_hz=RATE_HZ, repeat=False, keep=False, seed=seed)
    seen: dict[int, Counter[int]] = {}
    live = LiveRecognizer(
        recognizer, MemoryGallery(), look_every=3, search_every_s=0.2, search_again_s=0.6,
        background=False,
    )  # fmt: skip
    with live:
        for frame in camera:
            _note(seen, live.update(frame), frame)
        live.finish()
    votes: dict[int, Counter[int]] = {}
    for visit in live.visits:
        if visit.person is not None:
            votes.setdefault(visit.person, Counter()).update(seen.get(visit.track, Counter()))
    who = {person: heads.most_common(1)[0][0] for person, heads in votes.items() if heads}
    return Line(live, who, len(walks))


def _note(seen: dict[int, Counter[int]], answer: LiveFrame, frame: Frame) -> None:
    """Who is under each track, by the truth."""
    for track in answer.tracks:
        for true in frame.truth:
            if np.linalg.norm(true.pose.translation - np.array(track.nose_tip_mm)) < 80.0:
                seen.setdefault(track.number, Counter())[true.person] += 1


def _is_right(
    person: int, changed: bool, table: Sequence[Transfer], here: Line, there: Line
) -> bool:
    """Whether every row of a passenger says what is true, and there is one."""
    rows = [t for t in table if t.first is not None and here.who.get(t.first) == person]
    linked = [there.who.get(t.second) for t in rows if t.second is not None]
    if not rows or any(other != person for other in linked):
        return False
    return bool(linked) == changed
