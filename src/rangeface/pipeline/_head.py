"""A feature and the classifier that learns from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rangeface import describe
from rangeface.classify import Matcher, fitted_state, rounded
from rangeface.decide import per_subject
from rangeface.errors import DegenerateError, ParameterError
from rangeface.pipeline._step import Step
from rangeface.types import Float32, RangeImage

_INFRARED = frozenset(
    describe.METHODS[name] for name, output in describe.OUTPUTS.items() if output.needs_amplitude
)


@dataclass(frozen=True, eq=False)
class Head:
    """A feature and the classifier that learns from it.

    Parameters
    ----------
    describe : Step
        Frontal image → array.
    classify : Matcher
        Estimator of `rangeface.classify`, fitted or not.
    shipped : bool
        The classifier is to be that of the model that ships, which has learned from a background
        population: `recognizer.with_shipped_heads` puts it in, and `fit` leaves it as it is.
    """

    describe: Step
    classify: Matcher
    shipped: bool = False

    def sees(self, view: RangeImage) -> bool:
        """Whether the image has what the feature needs: an infrared one needs the amplitude."""
        return self.describe.method not in _INFRARED or view.amplitude is not None

    def features(self, views: Sequence[RangeImage]) -> Float32:
        """One row (n, D) for every frontal image that the feature can be taken from."""
        rows = [np.ravel(self.describe(view)) for view in views if self.sees(view)]
        return np.asarray(np.stack(rows) if rows else np.empty((0, 0)), np.float32)

    def fit(self, views: Sequence[RangeImage], subjects: Sequence[str]) -> Head:
        """The head with a new estimator of the same parameters, fitted to frontal images.

        Raises
        ------
        DegenerateError
            No image has what the feature needs.
        ParameterError
            The classifier was to be the shipped one, and nobody has put it in.
        """
        if self.shipped:
            if not fitted_state(self.classify):
                raise ParameterError(
                    f"heads: {self.describe.name} is to be the shipped one: "
                    "learn with FaceRecognizer.fit"
                )
            return self
        seen = [k for k, view in enumerate(views) if self.sees(view)]
        if not seen:
            raise DegenerateError(f"{self.describe.name}: no training capture has an amplitude")
        labels = np.asarray(subjects, dtype=str)[seen]
        estimator = type(self.classify)(**self.classify.get_params())
        return replace(self, classify=rounded(estimator.fit(self.features(views), labels)))

    def rows(self, views: Sequence[RangeImage]) -> Float32:
        """What a template keeps of frontal images: one row each, none where it sees nothing."""
        features = self.features(views if self.classify.needs_rotated_views else views[:1])
        if len(features):
            return self.classify.transform(features)
        return self.classify.transform(np.zeros((1, self.classify.n_features_in_)))[:0]

    def scores(self, probe: Float32, rows: Float32, owners: np.ndarray, count: int) -> Float32:
        """Scores (count,) of a probe's rows against people: of each, the best pair of rows."""
        if len(probe) == 0 or len(rows) == 0:
            return np.full(count, np.nan, np.float32)
        best = self.classify.similarity(probe, rows).max(axis=0)
        return per_subject(best, owners, count=count)
