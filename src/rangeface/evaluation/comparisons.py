"""Anyone's scores: who was compared with whom, and how alike they were.

A score file is CSV with the columns ``probe, reference, mated, score``, one comparison a line:
``mated`` is 1 where both show one person, an empty ``score`` is a probe that failed to acquire.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import DegenerateError, ScanError, ScanFault
from rangeface.evaluation.curves import cmc
from rangeface.evaluation.error_rates import (
    Rate,
    eer,
    failure_to_acquire,
    fnmr_at_fmr,
    mated_nonmated,
    rank_k,
)
from rangeface.evaluation.open_set import fnir_at_fpir
from rangeface.numerics.statistics import rule_of_three

COLUMNS = ("probe", "reference", "mated", "score")
_YES, _NO = frozenset({"1", "true", "yes"}), frozenset({"0", "false", "no"})
#: FMR (and FPIR) at which FNMR (and FNIR) are given, where there are comparisons enough.
FMRS = (0.1, 0.01, 0.001)


@dataclass(frozen=True, eq=False)
class Comparisons:
    """A table of scores, with the person of every row and column.

    Parameters
    ----------
    table : (n, m) float64
        Higher = more alike; NaN where no comparison was made.
    probes, references : tuple of str
        Names of rows and columns.
    probe_subjects, reference_subjects : tuple of str
        Who they show.
    """

    table: NDArray[np.float64]
    probes: tuple[str, ...]
    references: tuple[str, ...]
    probe_subjects: tuple[str, ...]
    reference_subjects: tuple[str, ...]

    @property
    def enrolled(self) -> NDArray[np.bool_]:
        """Which probes show somebody who is enrolled."""
        return np.isin(self.probe_subjects, self.reference_subjects)

    def split(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mated and non-mated scores."""
        return mated_nonmated(self.table, self.probe_subjects, self.reference_subjects)

    def closed(self) -> tuple[NDArray[np.float64], tuple[str, ...], tuple[str, ...]]:
        """Rows of enrolled people only, with their subjects: what identification is rated on."""
        rows = np.flatnonzero(self.enrolled)
        subjects = tuple(self.probe_subjects[row] for row in rows)
        return self.table[rows], subjects, self.reference_subjects

    def rates(self) -> dict[str, Rate]:
        """Every rate that these comparisons can show.

        Returns
        -------
        dict
            Name → rate: identification if a probe's person is enrolled, in an open set too if
            there are strangers; verification if there are both kinds of comparison; failures.
        """
        out: dict[str, Rate] = {}
        if self.enrolled.any():
            out["rank 1"] = rank_k(*self.closed(), k=1)
            out["rank 5"] = rank_k(*self.closed(), k=5)
        mated, nonmated = self.split()
        compared = int(np.count_nonzero(~np.isnan(nonmated)))
        if mated.size and compared:
            out["EER"] = eer(mated, nonmated)
            for fmr in FMRS:
                if fmr >= rule_of_three(compared):
                    out[f"FNMR at FMR {100 * fmr:g} %"] = fnmr_at_fmr(mated, nonmated, fmr)
        strangers = self.table[~self.enrolled]
        if self.enrolled.any():
            for fpir in FMRS:
                if len(strangers) and fpir >= rule_of_three(len(strangers)):
                    rate = fnir_at_fpir(*self.closed(), strangers, fpir)
                    out[f"FNIR at FPIR {100 * fpir:g} %"] = rate
        out["failure to acquire"] = failure_to_acquire(self.table)
        out["failure to enrol"] = failure_to_acquire(self.table.T)
        return out

    def worst(self, count: int) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
        """The mated pairs that are least alike, and the non-mated that are most: (row, column)."""
        same = np.equal.outer(self.probe_subjects, self.reference_subjects)
        compared = ~np.isnan(self.table)
        low = np.where(same & compared, self.table, np.inf)
        high = np.where(~same & compared, self.table, -np.inf)
        return _first(low, count), _first(-high, count)

    def cmc(self) -> NDArray[np.float64]:
        """Cumulative match characteristic of the enrolled people's probes."""
        return cmc(*self.closed())


def _first(values: NDArray[np.float64], count: int) -> list[tuple[int, int]]:
    order = np.argsort(values, axis=None, kind="stable")[:count]
    pairs = [divmod(int(place), values.shape[1]) for place in order]
    return [(row, column) for row, column in pairs if np.isfinite(values[row, column])]


def write_scores(path: Path, comparisons: Comparisons) -> None:
    """Write a score file.

    Parameters
    ----------
    path : Path
    comparisons : Comparisons
        Scores are written so that reading gives the same numbers.
    """
    c = comparisons
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row, probe, shows in zip(c.table, c.probes, c.probe_subjects, strict=True):
            for score, reference, subject in zip(
                row, c.references, c.reference_subjects, strict=True
            ):
                value = "" if np.isnan(score) else repr(float(score))
                writer.writerow((probe, reference, int(shows == subject), value))


def read_scores(path: Path) -> Comparisons:
    """Read a score file.

    Parameters
    ----------
    path : Path
        CSV with a header; columns in any order, more are ignored.

    Returns
    -------
    Comparisons
        Comparisons that the file does not list are NaN. People are named after their first
        reference; a probe that is mated to nobody is a stranger.

    Raises
    ------
    ScanError
        The file is missing, a column is, or a line is not understood.
    DegenerateError
        There is no comparison, or `mated` contradicts itself.
    """
    if not path.is_file():
        raise ScanError(path, ScanFault.MISSING, "a CSV with probe,reference,mated,score")
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.DictReader(file)
        missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
        if missing:
            raise ScanError(path, ScanFault.MALFORMED, f"no column {missing[0]!r}")
        lines = [_line(path, number, row) for number, row in enumerate(reader, start=2)]
    if not lines:
        raise DegenerateError(f"{path}: no comparison")
    return _arranged(path, lines)


_Line = tuple[str, str, bool, float]


def _line(path: Path, number: int, row: Mapping[str, str | None]) -> _Line:
    mated, score = ((row[name] or "").strip().lower() for name in ("mated", "score"))
    if mated not in _YES | _NO:
        raise ScanError(path, ScanFault.MALFORMED, f"line {number}: mated is {mated!r}, not 0 or 1")
    try:
        value = float(score) if score else float("nan")
    except ValueError:
        detail = f"line {number}: score is {score!r}, not a number"
        raise ScanError(path, ScanFault.MALFORMED, detail) from None
    return row["probe"] or "", row["reference"] or "", mated in _YES, value


def _arranged(path: Path, lines: Sequence[_Line]) -> Comparisons:
    probes = {name: k for k, name in enumerate(dict.fromkeys(line[0] for line in lines))}
    references = {name: k for k, name in enumerate(dict.fromkeys(line[1] for line in lines))}
    subject = _people(lines)
    table = np.full((len(probes), len(references)), np.nan)
    for probe, reference, mated, score in lines:
        if mated != (subject["probe", probe] == subject["reference", reference]):
            raise DegenerateError(f"{path}: mated contradicts itself at {probe!r}, {reference!r}")
        table[probes[probe], references[reference]] = score
    return Comparisons(
        table, tuple(probes), tuple(references),
        tuple(subject["probe", name] for name in probes),
        tuple(subject["reference", name] for name in references),
    )  # fmt: skip


def _people(lines: Sequence[_Line]) -> dict[tuple[str, str], str]:
    """Who each name shows: what is mated, directly or by way of others, is one person."""
    parent: dict[tuple[str, str], tuple[str, str]] = {}

    def root(name: tuple[str, str]) -> tuple[str, str]:
        while parent.setdefault(name, name) != name:
            parent[name] = parent[parent[name]]
            name = parent[name]
        return name

    for probe, reference, mated, _ in lines:
        one, other = root(("probe", probe)), root(("reference", reference))
        if mated:
            parent[one] = other
    return {
        name: root(name)[1] if root(name)[0] == "reference" else f"stranger {root(name)[1]}"
        for name in parent
    }
