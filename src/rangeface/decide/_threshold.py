"""The score that is needed, from the scores of people who are known to differ."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rangeface.errors import ParameterError
from rangeface.numerics.statistics import rule_of_three


def threshold_at_fmr(nonmated: ArrayLike, fmr: float) -> float:
    """Smallest threshold whose false match rate does not exceed the one wanted.

    Parameters
    ----------
    nonmated : (k,) array_like
        Scores of different people; NaN (not compared) is left out.
    fmr : float
        Wanted rate, 3 / k ≤ fmr < 1.

    Returns
    -------
    float
        Accept at or above.

    Raises
    ------
    ParameterError
        The rate is outside 0 … 1, or below 3 / k: so few comparisons cannot show it.

    Examples
    --------
    >>> threshold_at_fmr(np.arange(100), 0.05)
    95.0
    """
    made = np.asarray(nonmated, dtype=np.float64).ravel()
    made = np.sort(made[~np.isnan(made)])
    if not 0 < fmr < 1:
        raise ParameterError(f"fmr: must be in (0, 1), got {fmr}")
    if len(made) == 0 or fmr < rule_of_three(len(made)):
        raise ParameterError(
            f"fmr: {fmr:g} cannot be shown with {len(made)} comparisons of different people; "
            f"the smallest is 3 / {len(made)} = {3 / max(len(made), 1):.3g}"
        )
    allowed = int(fmr * len(made) + 1e-9)
    # of the candidates "just above a score", the lowest with at most `allowed` at or above it
    last_rejected = made[len(made) - allowed - 1]
    above = made[np.searchsorted(made, last_rejected, side="right") :]
    return float(above[0]) if len(above) else float(np.nextafter(last_rejected, np.inf))
