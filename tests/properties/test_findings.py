"""Verdicts, score files and the forms of a table."""

import csv
import io

import numpy as np
import pytest

from rangeface.evaluation.comparisons import Comparisons, read_scores, write_scores
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments._experiment import hits, sequence_hits
from rangeface.evaluation.findings import FAILS, HOLDS, UNDECIDED, Claim, Entry, Findings, judge
from rangeface.evaluation.findings import Table as Paper
from rangeface.evaluation.publish import Provenance, as_csv, as_latex, as_markdown, publish

PEOPLE = np.arange(60)


def verdict(first, second, margin=None):
    return judge([Claim("", "", first, second, PEOPLE, margin)])[0].verdict


def test_verdicts_follow_the_data():
    always, never, half = np.ones(60), np.zeros(60), np.arange(60) % 2
    assert verdict(always, never) == HOLDS
    assert verdict(never, always) == FAILS
    assert verdict(half, 1 - half) == UNDECIDED
    assert verdict(always, always) == UNDECIDED
    assert verdict(always, always, margin=0.1) == HOLDS
    assert verdict(always, never, margin=0.1) == FAILS
    assert verdict(half, 1 - half, margin=0.1) == UNDECIDED


def test_more_claims_need_more_evidence():
    first = np.zeros(60)
    first[:7] = 1.0
    claim = Claim("", "", first, np.zeros(60), PEOPLE)
    nothing = Claim("", "", np.ones(60), np.ones(60), PEOPLE)
    alone, among = judge([claim])[0], judge([claim, *[nothing] * 9])[0]
    assert alone.verdict == HOLDS
    assert among.verdict == UNDECIDED
    assert among.p == pytest.approx(10 * alone.p)


def test_a_fair_coin_is_seldom_called_loaded():
    rng = np.random.default_rng(0)
    called = sum(
        verdict(rng.integers(2, size=60), rng.integers(2, size=60)) != UNDECIDED for _ in range(100)
    )
    assert called <= 12  # 5 expected; 12 is above the 99.8 % quantile


def test_scores_come_back_from_their_file(tmp_path):
    rng = np.random.default_rng(1)
    table = rng.normal(size=(5, 3))
    table[2] = np.nan
    mine = Comparisons(table, tuple("vwxyz"), tuple("ABC"), tuple("ABCAS"), tuple("ABC"))
    write_scores(tmp_path / "scores.csv", mine)
    theirs = read_scores(tmp_path / "scores.csv")
    np.testing.assert_array_equal(theirs.table, table)
    assert theirs.probes == mine.probes
    assert theirs.references == mine.references
    same = np.equal.outer(theirs.probe_subjects, theirs.reference_subjects)
    np.testing.assert_array_equal(
        same, np.equal.outer(mine.probe_subjects, mine.reference_subjects)
    )
    assert theirs.rates() == mine.rates()
    assert theirs.enrolled.tolist() == [True, True, True, True, False]


def test_strangers_are_rated_in_an_open_set():
    subjects = ("A", "B", *(f"stranger {k}" for k in range(40)))
    table = np.zeros((42, 2))
    table[0, 0], table[1, 1] = 2.0, 0.5
    table[2:, 0] = np.linspace(0.0, 1.0, 40)
    some = Comparisons(table, subjects, ("A", "B"), subjects, ("A", "B"))
    # one stranger in ten scores above 0.9: B is not found there, A is
    assert some.rates()["FNIR at FPIR 10 %"].rate == 0.5
    assert "FNIR at FPIR 1 %" not in some.rates()


def test_the_worst_pairs_are_found():
    table = np.array([[0.1, 0.9], [0.8, 0.7], [np.nan, np.nan]])
    some = Comparisons(table, tuple("abc"), tuple("AB"), tuple("ABA"), tuple("AB"))
    mated, nonmated = some.worst(5)
    assert mated == [(0, 0), (1, 1)]
    assert nonmated == [(0, 1), (1, 0)]


def test_majority_and_first_view():
    # probe 0: two of three views say 0; probe 1: a tie that the sum decides; probe 2 failed
    scores = np.full((3, 3, 2), np.nan, np.float32)
    scores[0] = [[0, 1], [1, 0], [1, 0]]
    scores[1, :2] = [[0.0, 0.3], [0.2, 0.0]]
    result = {"scores": scores, "owner": np.array([0, 1, 0])}
    assert hits(result).tolist() == [False, True, False]
    assert sequence_hits(result).tolist() == [True, True, False]


def test_one_table_in_three_forms(tmp_path):
    entry = Entry(Rate.of(55, 60), 92)
    table = Paper("t", "σ & α", ["a|b", "c_d"], [[entry, "5 %"]])
    assert str(entry) == "92 [82, 96] (92)"
    assert list(csv.reader(io.StringIO(as_csv(table)))) == [["a|b", "c_d"], [str(entry), "5 %"]]
    assert "| a\\|b | c_d |" in as_markdown(table)
    assert r"c\_d" in as_latex(table)
    assert r"5 \%" in as_latex(table)
    report = publish(
        Findings("title", "why?", tables=[table]), tmp_path / "out",
        Provenance("command <b>", "data", "hash", 1.0, "serial"),
    )  # fmt: skip
    page = report.read_text()
    assert "command &lt;b&gt;" in page
    assert "http" not in page.replace("http-equiv", "")
    assert {p.name for p in report.parent.iterdir()} == {
        "report.html",
        "t.csv",
        "t.tex",
        "tables.md",
    }
