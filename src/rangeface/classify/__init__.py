"""What learns: feature vectors → scores.

Every entry of `METHODS` is a scikit-learn estimator with ``fit(X, y)``, ``transform(X)`` →
(n, D) float32 and ``similarity(P, G)`` → (n, m) scores, higher = more alike.
"""

from __future__ import annotations

from rangeface.classify._base import Matcher
from rangeface.classify._fisherface import FisherfaceLDA
from rangeface.classify._mlda import MLDA
from rangeface.classify._pca import PCA
from rangeface.classify._state import fitted_state, restore

METHODS: dict[str, type[Matcher]] = {
    "pca": PCA,
    "lda": FisherfaceLDA,
    "mlda": MLDA,
}

__all__ = ["METHODS", "MLDA", "PCA", "FisherfaceLDA", "Matcher", "fitted_state", "restore"]
