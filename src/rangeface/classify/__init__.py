"""What learns: feature vectors → scores.

Every entry of `METHODS` is a scikit-learn estimator with ``fit(X, y)``, ``transform(X)`` →
(n, D) float32 and ``similarity(P, G)`` → (n, m) scores, higher = more alike.
"""

from __future__ import annotations

from rangeface.classify._base import Matcher
from rangeface.classify._collaborative import CollaborativeRepresentation
from rangeface.classify._direct import Direct
from rangeface.classify._fisherface import FisherfaceLDA
from rangeface.classify._histogram import HistogramMatcher
from rangeface.classify._kernel_fisher import KernelFisher
from rangeface.classify._mlda import MLDA
from rangeface.classify._pca import PCA
from rangeface.classify._pearson import PearsonMatcher, WarpedPearsonMatcher
from rangeface.classify._regularized_lda import RegularizedLDA
from rangeface.classify._state import fitted_state, restore, rounded
from rangeface.classify._surface import SurfaceMatcher
from rangeface.classify._svm import SVM
from rangeface.classify._whitened_pca import WhitenedPCA

METHODS: dict[str, type[Matcher]] = {
    "pca": PCA,
    "whitened-pca": WhitenedPCA,
    "lda": FisherfaceLDA,
    "regularized-lda": RegularizedLDA,
    "mlda": MLDA,
    "kernel-fisher": KernelFisher,
    "crc": CollaborativeRepresentation,
    "svm": SVM,
    "direct": Direct,
    "histogram": HistogramMatcher,
    "pearson": PearsonMatcher,
    "warped-pearson": WarpedPearsonMatcher,
    "surface": SurfaceMatcher,
}

#: Those that learn from people's names; the others need only samples, or nothing at all.
SUPERVISED = frozenset({"lda", "regularized-lda", "mlda", "kernel-fisher", "svm"})

__all__ = [
    "METHODS",
    "MLDA",
    "PCA",
    "SUPERVISED",
    "SVM",
    "CollaborativeRepresentation",
    "Direct",
    "FisherfaceLDA",
    "HistogramMatcher",
    "KernelFisher",
    "Matcher",
    "PearsonMatcher",
    "RegularizedLDA",
    "SurfaceMatcher",
    "WarpedPearsonMatcher",
    "WhitenedPCA",
    "fitted_state",
    "restore",
    "rounded",
]
