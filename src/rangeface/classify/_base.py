"""What all estimators of this stage share: checked input, projection, similarity."""

from __future__ import annotations

from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from rangeface.errors import DegenerateError, ParameterError
from rangeface.numerics.similarity import similarity

Float32 = NDArray[np.float32]


class Matcher(TransformerMixin, BaseEstimator):
    """An estimator with ``fit``, ``transform`` → (n, D) float32 and ``similarity`` → (n, m)."""

    #: Whether a template gains by rotated views; not where the matcher aligns by itself.
    needs_rotated_views: ClassVar[bool] = True
    #: Whether each pair costs so much that a large gallery needs a shortlist.
    pairwise: ClassVar[bool] = False

    metric: str
    n_features_in_: int

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.transformer_tags.preserves_dtype = []  # float32, whatever came in
        return tags

    def _samples(self, X: ArrayLike, *, reset: bool = True) -> Any:
        """Finite samples (N, m); sets `n_features_in_`, or compares with it."""
        try:
            return validate_data(self, X, dtype=[np.float64, np.float32], reset=reset)
        except ValueError as error:
            raise ParameterError(f"{type(self).__name__}: {error}") from error

    def _samples_and_labels(self, X: ArrayLike, y: ArrayLike) -> tuple[Any, Any]:
        """Samples (N, m) and labels 0 … C − 1, C ≥ 2."""
        try:
            X, y = validate_data(self, X, y, dtype=[np.float64, np.float32])
            check_classification_targets(y)
        except ValueError as error:
            raise ParameterError(f"{type(self).__name__}: {error}") from error
        classes, labels = np.unique(np.asarray(y), return_inverse=True)
        if len(classes) < 2:
            raise DegenerateError(
                f"{type(self).__name__}: one class in n_samples = {len(labels)}; two are needed"
            )
        return X, labels

    def _fitted_samples(self, X: ArrayLike) -> Any:
        """Samples (n, m) of the width that was fitted."""
        check_is_fitted(self)
        return self._samples(X, reset=False)

    def similarity(self, probes: ArrayLike, gallery: ArrayLike) -> Float32:
        """Scores of transformed probes (n, D) against a transformed gallery (m, D): (n, m).

        Parameters
        ----------
        probes, gallery : (n, D) and (m, D) array_like
            Rows that `transform` gave.

        Returns
        -------
        (n, m) float32
            Higher = more alike.
        """
        return similarity(probes, gallery, metric=self.metric)


class SupervisedTags:
    """Mixin: `fit` needs to know who each sample is."""

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()  # type: ignore[misc]
        tags.target_tags.required = True
        return tags


class LinearProjection(Matcher):
    """A matcher whose transform is y = W (x − μ): ``mean_`` (m,) and ``components_`` (D, m)."""

    mean_: Float32
    components_: Float32
    n_components_: int

    def _keep(self, mean: NDArray[Any], components: NDArray[Any]) -> Self:
        self.mean_ = np.asarray(mean, dtype=np.float32)
        self.components_ = np.ascontiguousarray(components, dtype=np.float32)
        self.n_components_ = len(components)
        return self

    def transform(self, X: ArrayLike) -> Float32:
        """Project samples.

        Parameters
        ----------
        X : (n, m) array_like
            Samples in rows, finite.

        Returns
        -------
        (n, n_components_) float32
            Feature vectors.

        Raises
        ------
        ParameterError
            A value is not finite, or the width is not the fitted one.
        """
        samples = self._fitted_samples(X)
        return np.asarray((samples.astype(np.float32) - self.mean_) @ self.components_.T)


def check_count(name: str, value: int | None) -> int:
    """A wanted number of components as an int; None means as many as there are."""
    if value is None:
        return np.iinfo(np.int32).max
    if not (isinstance(value, int | np.integer) and value >= 1):
        raise ParameterError(f"{name}: must be an int ≥ 1 or None, got {value!r}")
    return int(value)
