"""Several frames of one person: one score for each enrolled person, and one decision."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.decide._open_set import open_set, refuse
from rangeface.errors import DegenerateError, ParameterError
from rangeface.types import Decision, Reason

Array = NDArray[np.float64]


def majority_vote(scores: ArrayLike) -> Array:
    """Share of the frames that each person wins.

    Parameters
    ----------
    scores : (F, S) array_like
        A row a frame; rows of NaN (frames that failed) do not vote.

    Returns
    -------
    (S,) float64
        Shares in 0 … 1. Equal shares are ordered by the sum of scores: less than a
        thousandth of a vote is added by rank of that sum.

    Raises
    ------
    ParameterError
        Not a table.
    DegenerateError
        No frame is usable.

    Examples
    --------
    >>> majority_vote([[2.0, 1.0], [3.0, 1.0], [0.0, 9.0]]).round(1)
    array([0.7, 0.3])
    """
    table = _usable(scores)
    votes = np.bincount(np.nanargmax(table, axis=1), minlength=table.shape[1])
    place = np.argsort(np.argsort(np.nan_to_num(sum_of_scores(table), nan=-np.inf)))
    return np.asarray((votes + 1e-3 * place / table.shape[1]) / len(table))


def sum_of_scores(scores: ArrayLike) -> Array:
    """Sum of the frames' scores, over their number, so that a threshold keeps its meaning.

    Parameters
    ----------
    scores : (F, S) array_like
        A row a frame; NaN where no comparison was made.

    Returns
    -------
    (S,) float64
        NaN for a person who was never compared.

    Raises
    ------
    ParameterError
        Not a table.
    DegenerateError
        No frame is usable.

    Examples
    --------
    >>> sum_of_scores([[1.0, 0.0], [2.0, 0.0], [np.nan, np.nan]])
    array([1.5, 0. ])
    """
    table = _usable(scores)
    made = np.count_nonzero(~np.isnan(table), axis=0)
    total = np.nansum(table, axis=0)
    return np.divide(total, made, out=np.full(table.shape[1], np.nan), where=made > 0)


SEQUENCE = {"sum": sum_of_scores, "majority": majority_vote}


def decide_sequence(
    scores: ArrayLike,
    subjects: Sequence[str],
    *,
    threshold: float,
    rule: str = "sum",
    margin: float = 0.0,
    min_frames: int = 1,
    top: int = 5,
) -> Decision:
    """Decide who a sequence of frames shows.

    Parameters
    ----------
    scores : (F, S) array_like
        A row a frame; rows of NaN are frames that were unfit or failed.
    subjects : sequence of str
        Who the columns are.
    threshold : float
        What the fused score must reach; for "majority" a share of the frames.
    rule : {"sum", "majority"}
        How frames are fused.
    margin : float
        As in `open_set`.
    min_frames : int
        Usable frames that are needed, ≥ 1.
    top : int
        Length of the ranking, ≥ 1.

    Returns
    -------
    Decision
        *cannot tell* (too few usable frames) where fewer than `min_frames` are usable.

    Raises
    ------
    ParameterError
        The rule is unknown, the sizes do not fit, or a parameter is out of range.

    Examples
    --------
    >>> decide_sequence([[2.0, 1.0], [3.0, 1.0]], ["ann", "bob"], threshold=2.0).subject
    'ann'
    """
    if rule not in SEQUENCE:
        raise ParameterError(f"rule: unknown {rule!r}; known are {', '.join(SEQUENCE)}")
    if min_frames < 1:
        raise ParameterError(f"min_frames: must be ≥ 1, got {min_frames}")
    if len(subjects) == 0:
        return open_set([], subjects, threshold=threshold, margin=margin, top=top)
    table = np.asarray(scores, dtype=np.float64)
    if np.count_nonzero(~np.isnan(table).all(axis=-1)) < min_frames:
        return refuse(Reason.TOO_FEW_FRAMES, threshold=threshold)
    return open_set(SEQUENCE[rule](table), subjects, threshold=threshold, margin=margin, top=top)


def _usable(scores: ArrayLike) -> Array:
    table = np.asarray(scores, dtype=np.float64)
    if table.ndim != 2:
        raise ParameterError(f"scores: expected a table (frames, people), got {table.shape}")
    usable = ~np.isnan(table).all(axis=1)
    if not usable.any():
        raise DegenerateError("scores: no frame is usable")
    return table[usable]
