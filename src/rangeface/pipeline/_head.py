"""A feature and the classifier that learns from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rangeface.classify import Matcher
from rangeface.pipeline._step import Step
from rangeface.types import Float32, RangeImage


@dataclass(frozen=True, eq=False)
class Head:
    """A feature and the classifier that learns from it.

    Parameters
    ----------
    describe : Step
        Frontal image → array.
    classify : Matcher
        Estimator of `rangeface.classify`, fitted or not.
    """

    describe: Step
    classify: Matcher

    def features(self, views: Sequence[RangeImage]) -> Float32:
        """One row (n, D) for every frontal image."""
        return np.stack([np.ravel(self.describe(view)) for view in views]).astype(np.float32)
