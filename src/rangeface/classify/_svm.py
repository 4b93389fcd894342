"""Support vector machines, one person against the rest."""

from __future__ import annotations

import warnings
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.exceptions import ConvergenceWarning
from sklearn.svm import LinearSVC

from rangeface.classify._base import LinearProjection, SupervisedTags
from rangeface.classify._span import span
from rangeface.errors import DegenerateError, ParameterError

_MAX_ITERATIONS = 10_000


class SVM(SupervisedTags, LinearProjection):
    r"""Linear support vector machines; a face is described by its distances to all of them.

    .. math::
        \min_{w_c} \tfrac12 \|w_c\|^2 + C \sum_k \max(0, 1 - t_{ck}\, w_c·(x_k - μ)/σ)^2,
        \quad t_{ck} = ±1

    Parameters
    ----------
    penalty : float
        C > 0.
    metric : {"cosine", "fisher-z", "euclidean"}
        Similarity of two vectors of decision values.

    Attributes
    ----------
    mean_ : (m,) float32
    components_ : (n_components_, m) float32
        One row a training person (one row for two people).
    n_components_ : int

    Raises
    ------
    ParameterError
        The penalty is not positive, or a sample is not finite.
    DegenerateError
        One class only, all samples alike, or the optimisation does not converge.

    Notes
    -----
    Comparing vectors of decision values, instead of asking for the largest, lets people enrol
    who were not in the training set. By the representer theorem w_c lies in the span of the
    samples; it is solved there. σ is the root mean square length of the centred samples.

    References
    ----------
    C. Cortes, V. Vapnik, Mach. Learn. 20, 1995, doi:10.1007/BF00994018.

    Examples
    --------
    >>> svm = SVM().fit([[0.0, 0.0], [0.0, 1.0], [4.0, 0.0], [4.0, 1.0]], [0, 0, 1, 1])
    >>> bool(svm.transform([[0.0, 0.5]])[0, 0] < 0 < svm.transform([[4.0, 0.5]])[0, 0])
    True
    """

    def __init__(self, *, penalty: float = 1.0, metric: str = "cosine") -> None:
        self.penalty = penalty
        self.metric = metric

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Find the machines of samples X (N, m) in rows, of people y (N,)."""
        samples, labels = self._samples_and_labels(X, y)
        if not (np.isfinite(self.penalty) and self.penalty > 0):
            raise ParameterError(f"penalty: must be > 0, got {self.penalty}")
        space = span(samples)
        scale = np.sqrt(np.square(space.coordinates).sum(axis=1).mean())
        machine = LinearSVC(
            C=self.penalty, dual=False, fit_intercept=False, max_iter=_MAX_ITERATIONS
        )
        with warnings.catch_warnings():
            warnings.simplefilter("error", ConvergenceWarning)
            try:
                machine.fit(space.coordinates / scale, labels)
            except ConvergenceWarning as warning:
                raise DegenerateError("SVM: does not converge; lower the penalty") from warning
        return self._keep(space.mean, space.lift(machine.coef_.T / scale))
