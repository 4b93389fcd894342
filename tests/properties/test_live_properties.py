"""Evidence, people, counts and links: what must hold whoever walks by."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rangeface.gallery import View
from rangeface.live import (
    Counts,
    Doorway,
    LiveFrame,
    People,
    Person,
    TrackView,
    Visit,
    count_people,
    link_people,
    write_transfers,
    write_visits,
)
from rangeface.live._evidence import Evidence
from rangeface.types import Reason, Template, Verdict


class Plain:
    """Scores templates by the negative distance of their vectors."""

    class pipeline:  # noqa: N801
        fingerprint = "f"

    nonmated = np.random.default_rng(0).normal(0.0, 1.0, 200_000).astype(np.float32)

    def threshold(self, fmr):
        return float(np.quantile(self.nonmated, 1 - fmr))

    def scores(self, probe: Template, references: View):
        return -np.linalg.norm(references.vectors[0] - probe.vectors[0][0], axis=1)


def template(*values):
    return Template((np.array([values], np.float32),), "f")


def visit(person, start_x, stop_x, track=1, looks=4):
    return Visit(track, person, None, Verdict.UNKNOWN, 0.0, 1.0,
                 (start_x, 0.0, 500.0), (stop_x, 0.0, 500.0), looks)  # fmt: skip


# ── evidence ─────────────────────────────────────────────────────────────────────────────


@given(fmr=st.floats(1e-4, 0.05), score=st.floats(-5.0, 12.0))
def test_evidence_is_the_likelihood_ratio_of_two_normal_laws(fmr, score):
    model = Plain()
    evidence = Evidence.of(model, fmr)
    mean, variance = float(model.nonmated.mean()), float(model.nonmated.var())
    mated = 2 * model.threshold(fmr) - mean
    ratio = ((score - mean) ** 2 - (score - mated) ** 2) / (2 * variance)
    assert evidence(np.array([score]))[0] == pytest.approx(ratio, rel=1e-4, abs=1e-3)


# ── people ───────────────────────────────────────────────────────────────────────────────


def test_people_are_known_again_and_nobody_is_there_twice():
    people = People(Plain(), threshold=lambda _: -1.0, remember_s=100.0)
    ann = people.meet(None, template(0.0), 0.0, set())
    bob = people.meet(None, template(5.0), 1.0, {ann.number})
    assert (ann.number, bob.number) == (1, 2)
    twin = people.meet(None, template(0.1), 2.0, {ann.number, bob.number})
    assert twin.number == 3
    again = people.meet(None, template(4.9), 3.0, set())
    assert (again.number, again.visits) == (2, 2)
    assert len(people) == 3


def test_nameless_people_are_forgotten_and_named_ones_are_not():
    people = People(Plain(), threshold=lambda _: -1.0, remember_s=10.0)
    people.meet(None, template(0.0), 0.0, set())
    people.meet("ann", template(9.0), 0.0, set())
    assert people.meet(None, template(0.0), 5.0, set()).visits == 2
    assert people.meet(None, template(0.0), 16.0, set()).number == 3
    assert people.meet("ann", None, 1000.0, set()).visits == 2


def test_who_stays_is_not_forgotten():
    people = People(Plain(), threshold=lambda _: -1.0, remember_s=10.0)
    ann = people.meet(None, template(0.0), 0.0, set())
    people.seen(ann.number, template(0.5), 9.0)
    assert people.meet(None, template(0.5), 18.0, set()).number == ann.number


def test_a_name_that_comes_late_joins_the_numbers_of_one_person():
    people = People(Plain(), threshold=lambda _: -1.0, remember_s=100.0)
    ann = people.meet("ann", template(0.0), 0.0, set())
    stranger = people.meet(None, template(5.0), 1.0, set())
    assert people.name(stranger.number, "bob", 2.0).number == stranger.number
    late = people.meet(None, template(9.0), 3.0, set())
    joined = people.name(late.number, "ann", 4.0)
    assert (joined.number, joined.visits) == (ann.number, 2)
    assert len(people) == 2
    assert people.name(joined.number, "carla", 5.0).number not in (ann.number, stranger.number)


def test_who_is_deleted_is_forgotten():
    people = People(Plain(), threshold=lambda _: -1.0, remember_s=100.0)
    people.meet("ann", template(0.0), 0.0, set())
    people.meet(None, template(5.0), 0.0, set())
    people.forget_names({"bob"})
    assert [person.subject for person in people.everybody()] == [None]


# ── counting ─────────────────────────────────────────────────────────────────────────────

PLACES = st.floats(-400.0, 400.0)
VISITS = st.lists(
    st.builds(visit, st.one_of(st.none(), st.integers(1, 5)), PLACES, PLACES), max_size=12
)


@given(visits=VISITS)
def test_seen_in_a_mirror_in_and_out_change_places(visits):
    there = count_people(visits, Doorway())
    back = count_people(visits, Doorway(inwards=-1))
    assert (there.went_in, there.went_out) == (back.went_out, back.went_in)
    assert (there.different_in, there.different_out) == (back.different_out, back.different_in)
    assert there.different == back.different
    assert there.went_in + there.went_out <= len(visits)
    assert there.different_in <= there.went_in


def test_a_count_by_hand():
    visits = [
        visit(1, -200, 200), visit(1, -200, 200), visit(2, 200, -200), visit(3, -200, -90),
        visit(None, -200, 200),
    ]  # fmt: skip
    assert count_people(visits) == Counts(3, 1, 1, 1, 3, 1)


@given(visits=VISITS)
def test_everybody_comes_closer_or_goes_away_along_z(visits):
    assert count_people(visits, Doorway("z", 500.0)).went_in == 0


@pytest.mark.parametrize("ending", ["csv", "json"])
def test_tables_are_written_row_by_row(ending, tmp_path):
    path = tmp_path / f"visits.{ending}"
    write_visits(path, [visit(1, -200, 200), visit(None, 200, -200)], source="mcap:a")
    text = path.read_text()
    if ending == "json":
        rows = json.loads(text)
        assert [row["direction"] for row in rows] == ["in", "out"]
        assert rows[1]["person"] is None
    else:
        assert len(text.splitlines()) == 3
        assert "mcap:a,1,1,,unknown,0.0,1.0,in,4" in text


# ── two cameras ──────────────────────────────────────────────────────────────────────────


def person(number, *values, subject=None, first=0.0, last=1.0):
    return Person(number, subject, template(*values) if values else None, first, last)


@given(order=st.permutations(range(6)), gone=st.sets(st.integers(0, 5), max_size=3))
def test_links_find_a_permutation_with_people_missing(order, gone):
    here = [person(k + 1, 10.0 * k) for k in range(6)]
    there = [person(100 + p, 10.0 * k + 0.1) for p, k in enumerate(order) if k not in gone]
    table = link_people(here, there, Plain(), threshold=-3.0)
    linked = {t.first - 1: order[t.second - 100] for t in table if t.first and t.second}
    assert linked == {k: k for k in range(6) if k not in gone}
    assert {t.first - 1 for t in table if t.second is None} == gone
    assert len(table) == 6


def test_names_link_people_at_once_and_strangers_stay_apart(tmp_path):
    here = [person(1, 0.0, subject="ann"), person(2, 50.0), person(3)]
    there = [person(7, 90.0, subject="ann", first=8.0), person(8, 70.0)]
    table = link_people(here, there, Plain(), threshold=-5.0)
    assert [(t.first, t.second) for t in table] == [(1, 7), (2, None), (3, None), (None, 8)]
    assert table[0].subject == "ann"
    assert (table[0].left_s, table[0].arrived_s) == (1.0, 8.0)
    write_transfers(tmp_path / "t.json", table)
    assert json.loads((tmp_path / "t.json").read_text())[1]["arrived_s"] is None
    write_transfers(tmp_path / "t.csv", table)
    assert len((tmp_path / "t.csv").read_text().splitlines()) == 5


# ── what is shown ────────────────────────────────────────────────────────────────────────


def test_an_answer_is_json():
    track = TrackView(
        1, (0, 0, 9, 9), (0.0, 0.0, 500.0), 1.0, 2.0, 3.0, 0.0, 0.0, Verdict.CANNOT_TELL, None,
        float("nan"), 7.0, -4.6, Reason.POSE, (("ann", float("-inf")),), 0, (),
    )  # fmt: skip
    shown = json.loads(json.dumps(LiveFrame(0, 0.0, 5.0, (track,)).as_dict(), allow_nan=False))
    assert shown["tracks"][0]["score"] is None
    assert shown["tracks"][0]["verdict"] == "cannot tell"
    assert shown["tracks"][0]["reason"] == "head turned too far"
    assert shown["tracks"][0]["ranking"] == [["ann", None]]
