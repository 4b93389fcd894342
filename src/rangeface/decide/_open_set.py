"""Who is this? An enrolled person, an unknown one, or an honest "cannot tell"."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from rangeface.errors import ParameterError
from rangeface.types import Assessment, Decision, Reason, Verdict


def open_set(
    scores: ArrayLike,
    subjects: Sequence[str],
    assessment: Assessment | None = None,
    *,
    threshold: float,
    margin: float = 0.0,
    top: int = 5,
) -> Decision:
    """Decide who a probe shows, if anybody who is enrolled.

    Parameters
    ----------
    scores : (S,) array_like
        One score for each enrolled person, higher = more alike; NaN where no comparison could
        be made.
    subjects : sequence of str
        Who they are, S different names.
    assessment : Assessment, optional
        Quality of the probe; any refusal in it withholds the decision.
    threshold : float
        Accept at or above.
    margin : float
        ≥ 0: the best score must exceed the second by more than this.
    top : int
        Length of the ranking that is kept, ≥ 1.

    Returns
    -------
    Decision
        *accepted*; *unknown* where nobody reaches the threshold or nobody is enrolled;
        *cannot tell* where the probe is unfit, could not be compared, or two people score alike.

    Raises
    ------
    ParameterError
        The sizes do not fit, or a parameter is out of range.

    Notes
    -----
    Quality is asked first: a poor image near to nobody is no evidence of a stranger.

    Examples
    --------
    >>> open_set([0.9, 0.2], ["ann", "bob"], threshold=0.5).subject
    'ann'
    >>> open_set([0.9, 0.8], ["ann", "bob"], threshold=0.5, margin=0.2).reason.value
    'two people score alike'
    >>> open_set([0.4, 0.2], ["ann", "bob"], threshold=0.5).verdict.value
    'unknown'
    """
    values = np.asarray(scores, dtype=np.float64)
    if values.shape != (len(subjects),):
        raise ParameterError(f"scores: {values.shape} does not fit {len(subjects)} subjects")
    if not margin >= 0 or top < 1 or np.isnan(threshold):
        raise ParameterError(
            f"threshold, margin, top: need a number, ≥ 0, ≥ 1; got {threshold}, {margin}, {top}"
        )
    if assessment is not None and not assessment.usable:
        return refuse(assessment.refusals[0], threshold=threshold)
    if len(subjects) == 0:
        return Decision(Verdict.UNKNOWN, threshold=threshold, reason=Reason.EMPTY_GALLERY)
    order = np.argsort(-values, kind="stable")[: np.count_nonzero(~np.isnan(values))]
    if len(order) == 0:
        return refuse(Reason.LOW_OVERLAP, threshold=threshold)
    ranking = tuple((subjects[i], float(values[i])) for i in order[:top])
    best = float(values[order[0]])
    lead = best - float(values[order[1]]) if len(order) > 1 else np.inf
    verdict, subject, reason = Verdict.ACCEPTED, subjects[order[0]], None
    if best < threshold:
        verdict, subject, reason = Verdict.UNKNOWN, None, Reason.BELOW_THRESHOLD
    elif not lead > margin:
        verdict, subject, reason = Verdict.CANNOT_TELL, None, Reason.AMBIGUOUS
    return Decision(verdict, subject, best, threshold, reason, ranking)


def verify(
    score: float, subject: str, assessment: Assessment | None = None, *, threshold: float
) -> Decision:
    """Decide whether a probe shows the person it claims to.

    Parameters
    ----------
    score : float
        Best score against that person's templates; NaN where none could be compared.
    subject : str
        Who it claims to be.
    assessment : Assessment, optional
        Quality of the probe; any refusal in it withholds the decision.
    threshold : float
        Accept at or above.

    Returns
    -------
    Decision
        *accepted*, *unknown* (below the threshold) or *cannot tell*.

    Raises
    ------
    ParameterError
        The threshold is NaN.

    Examples
    --------
    >>> verify(0.3, "ann", threshold=0.5).reason.value
    'no score above the threshold'
    """
    return open_set([score], [subject], assessment, threshold=threshold)


def refuse(reason: Reason, *, threshold: float = float("nan")) -> Decision:
    """The answer where no comparison was made: *cannot tell*, and why.

    Parameters
    ----------
    reason : Reason
        Why.
    threshold : float
        The score that would have been needed.

    Returns
    -------
    Decision

    Examples
    --------
    >>> refuse(Reason.NO_FACE).verdict.value
    'cannot tell'
    """
    return Decision(Verdict.CANNOT_TELL, threshold=threshold, reason=reason)
