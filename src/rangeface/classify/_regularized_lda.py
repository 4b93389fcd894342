"""Linear discriminant analysis with a shrunk within-class scatter."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from rangeface.classify._base import Float32, LinearProjection, SupervisedTags, check_count
from rangeface.classify._fisherface import discriminants
from rangeface.classify._span import oriented, scatter_between, scatter_within, span
from rangeface.errors import ParameterError


class RegularizedLDA(SupervisedTags, LinearProjection):
    r"""Linear discriminant analysis in the whole span, S_W shrunk towards a sphere.

    .. math:: S_γ = (1 - γ) S_W + γ \frac{\operatorname{tr} S_W}{r} I_r

    Parameters
    ----------
    n_components : int, optional
        Number of discriminant directions, ≥ 1; at most C − 1. None: C − 1.
    shrinkage : float
        γ, 0 < γ ≤ 1.
    metric : {"cosine", "fisher-z", "euclidean"}
        Similarity of two projections.

    Attributes
    ----------
    mean_ : (m,) float32
    components_ : (n_components_, m) float32
        Rows with W S_γ Wᵀ = (N − C) I, largest quotient first.
    quotients_ : (n_components_,) float32
    n_components_ : int

    Raises
    ------
    ParameterError
        A parameter is out of range, or a sample is not finite.
    DegenerateError
        One class only, all samples alike, or no variation within any class.

    Notes
    -----
    Unlike `FisherfaceLDA` it throws away no direction before it has seen the classes, and a
    direction in which few samples happen not to vary does not dominate.

    References
    ----------
    J. Friedman, J. Am. Stat. Assoc. 84(405), 1989, doi:10.1080/01621459.1989.10478752.

    Examples
    --------
    >>> X = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [5.0, 0.0, 0.0], [5.0, 2.0, 0.0]]
    >>> lda = RegularizedLDA(metric="euclidean").fit(X, [0, 0, 1, 1])
    >>> int(abs(lda.components_[0]).argmax())
    0
    """

    quotients_: Float32

    def __init__(
        self,
        n_components: int | None = None,
        *,
        shrinkage: float = 0.1,
        metric: str = "cosine",
    ) -> None:
        self.n_components = n_components
        self.shrinkage = shrinkage
        self.metric = metric

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Find the directions of samples X (N, m) in rows, of people y (N,)."""
        samples, labels = self._samples_and_labels(X, y)
        gamma = check_shrinkage(self.shrinkage)
        wanted = check_count("n_components", self.n_components)
        space = span(samples)
        Z = space.coordinates
        freedom = max(1, len(Z) - (labels.max() + 1))
        H_W = scatter_within(Z, labels) / np.sqrt(freedom)
        ridge = gamma * float(np.square(H_W).sum()) / Z.shape[1]
        quotients, W = discriminants(
            scatter_between(Z, labels), np.sqrt(1 - gamma) * H_W, ridge=ridge
        )
        kept = min(wanted, labels.max(), len(quotients))
        self.quotients_ = np.asarray(quotients[:kept], dtype=np.float32)
        return self._keep(space.mean, oriented(space.lift(W[:, :kept])))


def check_shrinkage(value: float) -> float:
    """γ as a float.

    Raises
    ------
    ParameterError
        It is not in (0, 1].
    """
    if not 0 < value <= 1:
        raise ParameterError(f"shrinkage: must be in (0, 1], got {value}")
    return float(value)
