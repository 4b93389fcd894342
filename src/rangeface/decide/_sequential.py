"""A sequence that stops as soon as the evidence suffices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rangeface.decide._open_set import open_set, refuse
from rangeface.errors import ParameterError
from rangeface.types import Decision, Reason, Verdict


@dataclass(frozen=True)
class Stopped:
    """A decision and what it took.

    Parameters
    ----------
    decision : Decision
        Its scores are the accumulated log-likelihood ratios.
    frames : int
        Frames looked at, failed ones included.
    """

    decision: Decision
    frames: int


def sequential(
    llr: ArrayLike,
    subjects: Sequence[str],
    *,
    fpir: float = 0.01,
    fnir: float = 0.01,
    correlation: float = 0.3,
    min_frames: int = 1,
) -> Stopped:
    r"""Wald's sequential probability ratio test over the frames of one person.

    .. math::
        Λ_c(n) = \frac{\sum_{f \le n} \mathrm{LLR}_{fc}}{1 + (n - 1) ρ}, \quad
        \text{accept at } \log\frac{(1 - β) S}{α}, \quad
        \text{reject at } \log\frac{β}{1 - α}

    Parameters
    ----------
    llr : (F, S) array_like
        Log-likelihood ratio of each frame for each enrolled person (`LlrFusion`); rows of NaN
        are frames that were unfit.
    subjects : sequence of str
        Who the columns are.
    fpir, fnir : float
        α and β, the error rates aimed at for the whole search, in (0, 0.5).
    correlation : float
        ρ in 0 … 1: correlation of two frames' evidence. 0 is Wald's test for independent
        frames; 1 trusts no more than the mean frame.
    min_frames : int
        Usable frames that are needed, ≥ 1.

    Returns
    -------
    Stopped
        *accepted* when one person's evidence reaches the upper bound and nobody else's does;
        *unknown* when everybody's falls below the lower one; *cannot tell* (too few usable
        frames, or two people alike) where the sequence ends first.

    Raises
    ------
    ParameterError
        The sizes do not fit, or a parameter is out of range.

    Notes
    -----
    Frames of one person in one pose share their errors: their plain sum grows without limit
    and a wrong identity is sure to pass any bound. Dividing by the variance inflation of n
    equally correlated frames caps the evidence at mean / ρ, however many frames come. α is
    shared among the S people of the search (Bonferroni).

    References
    ----------
    A. Wald, Ann. Math. Stat. 16(2), 1945, doi:10.1214/aoms/1177731118;
    L. Kish, Survey Sampling, 1965, sec. 5.4 (the variance inflation).

    Examples
    --------
    >>> frames = np.tile([4.0, -4.0], (20, 1))
    >>> stopped = sequential(frames, ["ann", "bob"], correlation=0.2)
    >>> stopped.decision.subject, stopped.frames
    ('ann', 2)
    """
    table = np.asarray(llr, dtype=np.float64)
    _check(table, len(subjects), fpir, fnir, correlation, min_frames)
    if len(subjects) == 0:
        return Stopped(open_set([], subjects, threshold=np.inf), 0)
    upper = float(np.log((1 - fnir) * len(subjects) / fpir))
    lower = float(np.log(fnir / (1 - fpir)))
    total, used = np.zeros(len(subjects)), 0
    decision = refuse(Reason.TOO_FEW_FRAMES, threshold=upper)
    for number, frame in enumerate(table, start=1):
        if np.isnan(frame).all():
            continue
        total, used = total + np.nan_to_num(frame), used + 1
        if used < min_frames:
            continue
        evidence = total / (1 + (used - 1) * correlation)
        rivals = np.count_nonzero(evidence >= upper)
        decision = open_set(evidence, subjects, threshold=upper)
        if rivals == 1 or evidence.max() <= lower:
            return Stopped(decision, number)
    if decision.verdict is not Verdict.CANNOT_TELL:  # the sequence ended between the bounds
        alike = decision.score >= upper
        reason = Reason.AMBIGUOUS if alike else Reason.TOO_FEW_FRAMES
        decision = Decision(
            Verdict.CANNOT_TELL, None, decision.score, upper, reason, decision.ranking
        )
    return Stopped(decision, len(table))


def _check(
    table: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    count: int,
    fpir: float,
    fnir: float,
    correlation: float,
    min_frames: int,
) -> None:
    if table.ndim != 2 or table.shape[1] != count:
        raise ParameterError(f"llr: {table.shape} does not fit {count} subjects")
    if not (0 < fpir < 0.5 and 0 < fnir < 0.5):
        raise ParameterError(f"fpir, fnir: must be in (0, 0.5), got {fpir}, {fnir}")
    if not 0 <= correlation <= 1:
        raise ParameterError(f"correlation: must be in 0 … 1, got {correlation}")
    if min_frames < 1:
        raise ParameterError(f"min_frames: must be ≥ 1, got {min_frames}")
