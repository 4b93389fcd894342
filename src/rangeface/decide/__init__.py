"""scores and Assessment → Decision.

Scores are higher = more alike; a missing comparison is NaN. The answers are *accepted*,
*unknown* and *cannot tell*, the last two with a reason.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rangeface.decide._fuse import linear_llr, sum_rule, weighted_sum
from rangeface.decide._llr import LlrFusion
from rangeface.decide._norms import robust_norm, s_norm, t_norm, z_norm
from rangeface.decide._open_set import open_set, refuse, verify
from rangeface.decide._per_subject import per_subject
from rangeface.decide._pooled import no_norm, pooled_norm
from rangeface.decide._sequence import SEQUENCE, decide_sequence, majority_vote, sum_of_scores
from rangeface.decide._sequential import Stopped, sequential
from rangeface.decide._threshold import threshold_at_fmr

METHODS: dict[str, Callable[..., Any]] = {"open-set": open_set}
FUSE: dict[str, Callable[..., Any]] = {"sum": sum_rule, "weighted": weighted_sum, "llr": linear_llr}
PER_HEAD: dict[str, Callable[..., Any]] = {"none": no_norm, "pooled": pooled_norm}
NORMALISE: dict[str, Callable[..., Any]] = {
    "z": z_norm,
    "t": t_norm,
    "s": s_norm,
    "robust": robust_norm,
}

__all__ = [
    "FUSE",
    "METHODS",
    "NORMALISE",
    "PER_HEAD",
    "SEQUENCE",
    "LlrFusion",
    "Stopped",
    "decide_sequence",
    "linear_llr",
    "majority_vote",
    "no_norm",
    "open_set",
    "per_subject",
    "pooled_norm",
    "refuse",
    "robust_norm",
    "s_norm",
    "sequential",
    "sum_of_scores",
    "sum_rule",
    "t_norm",
    "threshold_at_fmr",
    "verify",
    "weighted_sum",
    "z_norm",
]
