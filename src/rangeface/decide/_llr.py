"""Scores of one or several matchers → one log-likelihood ratio."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import expit
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from rangeface.errors import DegenerateError, ParameterError

Array = NDArray[np.float64]

_RIDGE = 1e-3  # keeps the weights finite where the two kinds are separable


class LlrFusion(ClassifierMixin, BaseEstimator):
    r"""Logistic calibration and fusion of scores, weights shrunk towards equal ones.

    .. math::
        \mathrm{LLR}(s) = b + \sum_h w_h \frac{s_h - c_h}{σ_h}, \quad
        \min_{w, b} \operatorname{mean}_{±} \log(1 + e^{∓\mathrm{LLR}})
        + \tfrac{λ}{2} \sum_h (w_h - \bar w)^2

    Parameters
    ----------
    shrinkage : float
        λ ≥ 0. 0: plain logistic regression; ∞ in the limit: the sum rule on normalised scores.

    Attributes
    ----------
    classes_ : (2,) array
        The second is "mated" (True of a bool, the larger of two labels).
    centre_, scale_ : (H,) float64
        c, midway between the two kinds, where a score says nothing; σ, the spread within kinds.
    weights_ : (H,) float64
    bias_ : float

    Raises
    ------
    ParameterError
        The shrinkage is negative, a score is infinite, or y has not two values.
    DegenerateError
        One kind only, or a matcher without scores of both kinds.

    Notes
    -----
    Both kinds weigh alike whatever their number, so the result is a likelihood ratio, not a
    posterior. A missing score (NaN) counts as c: no evidence. With H = 1 this is calibration.
    Fitted by Newton's method; convex.

    References
    ----------
    N. Brümmer et al., IEEE Trans. Audio Speech Lang. Process. 15(7), 2007,
    doi:10.1109/TASL.2007.902870.

    Examples
    --------
    >>> s = np.array([[-1.0], [0.0], [1.0], [2.0]])
    >>> calibration = LlrFusion().fit(s, [False, True, False, True])
    >>> abs(calibration.decision_function([[0.5]]).round(6))
    array([0.])
    """

    classes_: NDArray[Any]
    centre_: Array
    scale_: Array
    weights_: Array
    bias_: float
    n_features_in_: int

    def __init__(self, *, shrinkage: float = 0.01) -> None:
        self.shrinkage = shrinkage

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Fit to scores X (k, H) of pairs, NaN where missing, of kinds y (k,): mated or not."""
        if not (np.isfinite(self.shrinkage) and self.shrinkage >= 0):
            raise ParameterError(f"shrinkage: must be ≥ 0, got {self.shrinkage}")
        scores, mated = self._pairs(X, y)
        kinds = scores[mated], scores[~mated]
        if any(np.isnan(kind).all(axis=0).any() for kind in kinds):
            raise DegenerateError("LlrFusion: a matcher has no scores of one kind")
        means = np.stack([np.nanmean(kind, axis=0) for kind in kinds])
        spread = np.sqrt(np.mean([np.nanvar(kind, axis=0) for kind in kinds], axis=0))
        width = np.maximum(spread, 1e-6 * np.abs(means[0] - means[1]))
        self.centre_ = means.mean(axis=0)
        self.scale_ = np.where(width > 0, width, 1.0)
        parameters = _newton(self._design(scores), mated, float(self.shrinkage))
        self.weights_, self.bias_ = parameters[:-1], float(parameters[-1])
        return self

    def decision_function(self, X: ArrayLike) -> Array:
        """Log-likelihood ratios (k,) of scores X (k, H), NaN where missing; natural logarithm.

        Raises
        ------
        ParameterError
            A score is infinite, or the width is not the fitted one.
        """
        check_is_fitted(self)
        try:
            scores = validate_data(
                self, X, reset=False, dtype=np.float64, ensure_all_finite="allow-nan"
            )
        except ValueError as error:
            raise ParameterError(f"LlrFusion: {error}") from error
        return np.asarray(self._design(scores) @ np.append(self.weights_, self.bias_))

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """The likelier kind of each pair, (k,)."""
        likelier = (self.decision_function(X) > 0).astype(int)
        return self.classes_[likelier]

    def parameters(self) -> dict[str, Any]:
        """What `linear_llr` needs, as plain numbers that a configuration can hold."""
        check_is_fitted(self)
        return {
            "weights": tuple(self.weights_.tolist()),
            "centres": tuple(self.centre_.tolist()),
            "scales": tuple(self.scale_.tolist()),
            "bias": self.bias_,
        }

    def _pairs(self, X: ArrayLike, y: ArrayLike) -> tuple[Array, NDArray[np.bool_]]:
        try:
            scores, kinds = validate_data(
                self, X, y, dtype=np.float64, ensure_all_finite="allow-nan"
            )
            check_classification_targets(kinds)
        except ValueError as error:
            raise ParameterError(f"LlrFusion: {error}") from error
        self.classes_, labels = np.unique(kinds, return_inverse=True)
        if len(self.classes_) < 2:
            raise DegenerateError("LlrFusion: one class; mated and non-mated pairs are needed")
        if len(self.classes_) > 2:
            raise ParameterError(
                "Only binary classification is supported. The type of the target is multiclass."
            )
        return scores, labels == 1

    def _design(self, scores: Array) -> Array:
        evidence = np.nan_to_num((scores - self.centre_) / self.scale_)
        return np.column_stack([evidence, np.ones(len(evidence))])

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan = True
        tags.classifier_tags.multi_class = False
        return tags


def _newton(A: Array, mated: NDArray[np.bool_], shrinkage: float) -> Array:
    """Minimiser of the penalised, kind-balanced logistic loss; the last parameter is b."""
    H = A.shape[1] - 1
    importance = np.where(mated, 0.5 / mated.sum(), 0.5 / (~mated).sum())
    penalty = np.zeros((H + 1, H + 1))
    penalty[:H, :H] = shrinkage * (np.eye(H) - 1.0 / H) + _RIDGE * np.eye(H)

    def loss(theta: Array) -> float:
        margins = np.where(mated, 1.0, -1.0) * (A @ theta)
        return float(importance @ np.logaddexp(0.0, -margins) + 0.5 * theta @ penalty @ theta)

    theta = np.zeros(H + 1)
    for _ in range(100):
        p = expit(A @ theta)
        gradient = A.T @ (importance * (p - mated)) + penalty @ theta
        curvature = (A * (importance * p * (1 - p))[:, None]).T @ A + penalty
        curvature[H, H] += 1e-12
        step = np.linalg.solve(curvature, gradient)
        if np.abs(step).max() < 1e-10:
            break
        length = 1.0
        while loss(theta - length * step) > loss(theta) and length > 1e-8:
            length /= 2
        theta = theta - length * step
    return theta
