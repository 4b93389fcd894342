"""A fitted estimator as plain values and arrays, and back: what a model file stores."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
from sklearn.base import BaseEstimator

T = TypeVar("T", bound=BaseEstimator)


def fitted_state(estimator: BaseEstimator) -> dict[str, Any]:
    """Everything that `fit` learned: the attributes that end in one underscore.

    Parameters
    ----------
    estimator : estimator
        Fitted; of this stage, or any other of ours that learns.

    Returns
    -------
    dict
        Name → numpy array, or plain int, float, str.

    Examples
    --------
    >>> from rangeface.classify import PCA, restore
    >>> pca = PCA(1).fit([[0.0, 1.0], [2.0, 1.0]])
    >>> sorted(fitted_state(pca))
    ['components_', 'eigenvalues_', 'mean_', 'n_components_', 'n_features_in_']
    >>> restore(PCA, pca.get_params(), fitted_state(pca)).transform([[2.0, 1.0]])
    array([[1.]], dtype=float32)
    """
    learned = {
        name: value
        for name, value in vars(estimator).items()
        if name.endswith("_") and not name.startswith("_") and name != "feature_names_in_"
    }
    return {
        name: value.item() if isinstance(value, np.generic) else value
        for name, value in learned.items()
    }


def restore(kind: type[T], params: Mapping[str, Any], state: Mapping[str, Any]) -> T:
    """The fitted estimator that `get_params` and `fitted_state` described.

    Parameters
    ----------
    kind : type
        Class of the estimator, for instance from `METHODS`.
    params : mapping
        Constructor's parameters.
    state : mapping
        What `fitted_state` gave.

    Returns
    -------
    estimator
        Equal to the one described.
    """
    estimator = kind(**params)
    for name, value in state.items():
        setattr(estimator, name, value)
    return estimator


def rounded(estimator: T) -> T:
    """The fitted estimator with its projection rounded to half precision, for a small file.

    Every number becomes a power of two, common to all, times a half-precision number: 11
    significant bits. Scores move by less than 1e-3 of their range.

    Parameters
    ----------
    estimator : estimator
        Fitted; changed in place.

    Returns
    -------
    estimator
        The same one.

    Examples
    --------
    >>> from rangeface.classify import PCA
    >>> pca = PCA(1).fit([[0.0, 1.0], [2.0, 1.1]])
    >>> before = pca.components_.copy()
    >>> float(abs(rounded(pca).components_ / before - 1).max()) < 2**-11
    True
    """
    components = getattr(estimator, "components_", None)
    if isinstance(components, np.ndarray) and components.dtype == np.float32:
        exponent = int(np.frexp(np.abs(components).max())[1])
        half = np.ldexp(components, -exponent).astype(np.float16)
        estimator.components_ = np.ldexp(half.astype(np.float32), exponent)
    return estimator
