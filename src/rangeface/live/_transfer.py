"""The commuter's change of line: the same people, without a name, before two cameras."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from rangeface.gallery import stack
from rangeface.live._people import Person
from rangeface.live._visits import write_rows
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Float64, Template


@dataclass(frozen=True)
class Transfer:
    """One row of the transfer table.

    Parameters
    ----------
    first : int, optional
        The person's number at the first camera; None: was not seen there.
    second : int, optional
        The person's number at the second camera; None: was not seen there.
    subject : str, optional
        Name, if enrolled.
    score : float
        Likeness of the two; NaN where there is one only, or a name links them.
    left_s, arrived_s : float
        Last seen at the first camera, first seen at the second; NaN where not.
    """

    first: int | None
    second: int | None
    subject: str | None
    score: float
    left_s: float
    arrived_s: float


def link_people(
    first: Sequence[Person],
    second: Sequence[Person],
    recognizer: FaceRecognizer,
    *,
    threshold: float,
) -> list[Transfer]:
    """Say who of the first camera's people is who of the second's.

    Every person has at most one counterpart. Names link people at once; of the others the
    assignment is chosen whose scores above the threshold have the largest sum.

    Parameters
    ----------
    first, second : sequence of Person
        `LiveRecognizer.people.everybody()` of two cameras; with clocks that agree.
    recognizer : FaceRecognizer
        That made the templates.
    threshold : float
        Score that a link needs.

    Returns
    -------
    list of Transfer
        A row for everybody: linked people, then who was seen at one camera only.
    """
    by_name = {p.subject: p for p in second if p.subject is not None}
    rows = [_row(p, by_name[p.subject], float("nan")) for p in first if p.subject in by_name]
    here = [p for p in first if p.subject is None and p.template is not None]
    there = [p for p in second if p.subject is None and p.template is not None]
    scores = _scores(here, there, recognizer)
    gain = np.maximum(scores - threshold, 0.0)
    for i, k in zip(*linear_sum_assignment(-gain), strict=True):
        if gain[i, k] > 0.0:
            rows.append(_row(here[i], there[k], float(scores[i, k])))
    linked = [{row.first for row in rows}, {row.second for row in rows}]
    rows += [_row(p, None, float("nan")) for p in first if p.number not in linked[0]]
    rows += [_row(None, p, float("nan")) for p in second if p.number not in linked[1]]
    return rows


def write_transfers(path: str | Path, transfers: Sequence[Transfer]) -> None:
    """Write a transfer table to a CSV or JSON file.

    Parameters
    ----------
    path : str or Path
        Ends in ``.csv`` or ``.json``.
    transfers : sequence of Transfer

    Raises
    ------
    ParameterError
        The ending is another.
    """
    rows = [
        {k: None if isinstance(v, float) and np.isnan(v) else v for k, v in asdict(t).items()}
        for t in transfers
    ]
    write_rows(path, rows, tuple(Transfer.__dataclass_fields__))


def _scores(here: Sequence[Person], there: Sequence[Person], recognizer: FaceRecognizer) -> Float64:
    """Mean of the scores of both directions (test normalisation is not symmetric)."""
    if not here or not there:
        return np.zeros((len(here), len(there)))
    return 0.5 * (_directed(here, there, recognizer) + _directed(there, here, recognizer).T)


def _directed(
    probes: Sequence[Person], references: Sequence[Person], recognizer: FaceRecognizer
) -> Float64:
    named: list[tuple[str, Template]] = [
        (str(p.number), p.template) for p in references if p.template is not None
    ]
    view = stack(named, recognizer.pipeline.fingerprint)
    return np.array(
        [recognizer.scores(p.template, view) for p in probes if p.template is not None], np.float64
    )


def _row(first: Person | None, second: Person | None, score: float) -> Transfer:
    one = first or second
    return Transfer(
        first=None if first is None else first.number,
        second=None if second is None else second.number,
        subject=None if one is None else one.subject,
        score=score,
        left_s=float("nan") if first is None else first.last_s,
        arrived_s=float("nan") if second is None else second.first_s,
    )
