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
