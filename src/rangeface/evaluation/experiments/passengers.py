"""How well are people counted, and followed from one line to another, without a name?

Passengers walk past a camera on their line in groups of up to three, some of them twice; later
most of them walk past the camera of a second line, in other groups, with some who were not on
the first. Nobody is enrolled. Asked of the model that ships: how many different people passed,
and who of the first line is who of the second.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rangeface.errors import ParameterError
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments import models
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Findings, Table
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.gallery import MemoryGallery
from rangeface.live import Doorway, LiveFrame, LiveRecognizer, Transfer, count_people, link_people
from rangeface.recognizer import FaceRecognizer
from rangeface.sources import Frame, SyntheticCamera, Walk

SENSOR, RATE_HZ = "pmd-flexx2", 15.0
_DISTANCE_MM, _APART_MM, _OUTSIDE_MM = 650.0, 225.0, 760.0
_PASSAGE_S, _PAUSE_S = 3.6, 1.4
#: Each with other people.
DAYS = 2
TITLE = "Passengers: counted, and followed from line to line"


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


# ── cells ────────────────────────────────────────────────────────────────────────────────


@kept
def day(store: Store, *, source: Source, model: str, number: int) -> Arrays:
    """Let passengers walk by, count them, and link the two lines.

    Four of five change to the second line, one of five passes the first camera twice; for seven
    passengers there is one on the second line who was not on the first.

    Returns
    -------
    dict
        Of both lines, (2,) each: "people" and "different", true and counted; "passages" and
        "went_in", true and counted; "nobody": visits of whom too little was seen. "changed" and
        "linked": people who changed lines, truly and by the table; "right": passengers of whom
        every row of the table is true.
    """
    asked, run = models.recognizer(model), DAYS * source.seed + number
    rng = np.random.default_rng(run)
    passengers, joining = source.persons, max(1, source.persons // 7)
    people = models.newcomers(source) + number * (passengers + joining)
    first, newcomers = np.split(people + np.arange(passengers + joining), [passengers])
    again = rng.permutation(first)[: passengers // 5]
    changed = rng.permutation(first)[: 4 * passengers // 5]
    order = [*rng.permutation(first).tolist(), *rng.permutation(again).tolist()]
    here = _watch(asked, _walks(order, rng), seed=2 * run)
    later = rng.permutation(np.concatenate([changed, newcomers])).tolist()
    there = _watch(asked, _walks(later, rng), seed=2 * run + 1)
    table = link_people(
        here.live.people.everybody(), there.live.people.everybody(), asked,
        threshold=here.live.people.threshold(len(there.live.people)),
    )  # fmt: skip
    counts = [count_people(line.live.visits, Doorway()) for line in (here, there)]
    right = sum(_is_right(int(p), p in changed, table, here, there) for p in first)
    linked = sum(t.first is not None and t.second is not None for t in table)
    found = {
        "people": [passengers, len(later)],
        "different": [c.different for c in counts],
        "passages": [here.passages, there.passages],
        "went_in": [c.went_in for c in counts],
        "nobody": [c.nobody for c in counts],
        "changed": len(changed),
        "linked": linked,
        "right": right,
    }
    return {name: np.array(value) for name, value in found.items()}


def cells(source: Source) -> list[Cell]:
    """A cell a day."""
    if source.kind != "synthetic":
        raise ParameterError("data: passengers walk before the synthetic camera: synthetic only")
    return [cell(day, source=source, model=models.shipped(), number=k) for k in range(DAYS)]


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


# ── what comes of it ─────────────────────────────────────────────────────────────────────


def tabulate(source: Source, results: Results) -> Findings:
    """A row a day and line, and how many passengers were followed rightly."""
    days = [results(one) for one in cells(source)]
    counts = [
        [f"{k + 1}", line, *(f"{found[name][i]} ({found[true][i]})" for name, true in _COUNTED),
         int(found["nobody"][i])]
        for k, found in enumerate(days)
        for i, line in enumerate(("first", "second"))
    ]  # fmt: skip
    links = [
        [f"{k + 1}", _right(source, [found]), f"{found['linked']} ({found['changed']})"]
        for k, found in enumerate(days)
    ]
    links.append(["all", _right(source, days), ""])
    return Findings(
        TITLE, "How many different people passed, and who of the first line is who of the second?",
        readings=list(READINGS),
        tables=[
            Table("transfers", "Passengers of whom all that is said of their change is true [95 %]",
                  ["day", "transfers right", "links made (true)"], links),
            Table("counts", "Counted (true)",
                  ["day", "line", "different people", "passages", "too little seen"], counts),
        ],
    )  # fmt: skip


_COUNTED = (("different", "people"), ("went_in", "passages"))


def _right(source: Source, days: Sequence[Arrays]) -> str:
    return str(Rate.of(sum(int(d["right"]) for d in days), source.persons * len(days)))


READINGS = (
    "pmd flexx2 class, 224 × 172 pixels, 65 cm, 15 frames a second; groups of one to three "
    "abreast; a passage takes 3.6 s, of which a face is seen for about 2.",
    "One passenger of five passes the first camera twice, four of five change to the second line, "
    "where one for every seven is new. Each day has other people. Nobody is enrolled.",
    "A merge of two people costs one person in the count and up to two rows of the table.",
)

EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=30, minutes=6.0)
