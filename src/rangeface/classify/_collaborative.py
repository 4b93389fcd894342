"""Collaborative representation: which enrolled person explains the probe, with all others' help."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_factor, cho_solve

from rangeface.classify._base import Float32
from rangeface.classify._pca import PCA
from rangeface.errors import ParameterError


class CollaborativeRepresentation(PCA):
    r"""Collaborative representation with regularised least squares (CRC-RLS).

    .. math::
        \hat α = \arg\min_α \|p - G^T α\|^2 + λ\|α\|^2, \quad
        s_c = -\frac{\|p - G_c^T \hat α_c\|}{\|\hat α_c\|}

    Parameters
    ----------
    n_components : int, optional
        Dimensions that PCA leaves, ≥ 1. None: all.
    regularization : float
        λ > 0, for rows of unit length.

    Attributes
    ----------
    mean_, components_, eigenvalues_, n_components_
        As in `PCA`.

    Raises
    ------
    ParameterError
        A parameter is out of range, or a sample is not finite.
    DegenerateError
        One sample only, or all are alike.

    Notes
    -----
    The gallery itself is the dictionary, so a score depends on who else is enrolled, and
    enrolling needs no training. Projections are brought to unit length. The D × D normal
    equations cost O(m D² + D³) a call, whatever the number of probes.

    References
    ----------
    L. Zhang, M. Yang, X. Feng, ICCV 2011, doi:10.1109/ICCV.2011.6126277.

    Examples
    --------
    >>> crc = CollaborativeRepresentation().fit(np.eye(3))
    >>> gallery = crc.transform(np.eye(3))
    >>> int(crc.similarity(crc.transform([[0.9, 0.2, 0.1]]), gallery).argmax())
    0
    """

    def __init__(self, n_components: int | None = None, *, regularization: float = 0.01) -> None:
        self.n_components = n_components
        self.regularization = regularization

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Find the principal components of samples X (N, m) in rows; y is ignored."""
        if not (np.isfinite(self.regularization) and self.regularization > 0):
            raise ParameterError(f"regularization: must be > 0, got {self.regularization}")
        return super().fit(X)

    def transform(self, X: ArrayLike) -> Float32:
        """Project samples (n, m) and bring them to unit length: (n, n_components_) float32.

        Raises
        ------
        ParameterError
            A value is not finite, or the width is not the fitted one.
        """
        Y = super().transform(X)
        length = np.linalg.norm(Y, axis=1, keepdims=True)
        return np.asarray(Y / np.where(length > 0, length, 1.0), dtype=np.float32)

    def similarity(
        self, probes: ArrayLike, gallery: ArrayLike, owners: ArrayLike | None = None
    ) -> Float32:
        """Scores of transformed probes (n, D) against a transformed gallery (m, D): (n, m).

        Parameters
        ----------
        probes, gallery : (n, D) and (m, D) array_like
            Rows that `transform` gave.
        owners : (m,) array_like of int, optional
            Person of each gallery row: rows of one person explain a probe together, and all get
            that person's score. None: every row is a person.

        Returns
        -------
        (n, m) float32
            Higher = more alike.
        """
        P = np.asarray(probes, dtype=np.float64)
        G = np.asarray(gallery, dtype=np.float64)
        labels = np.arange(len(G)) if owners is None else np.asarray(owners)
        _, people = np.unique(labels, return_inverse=True)
        normal = G.T @ G + self.regularization * np.eye(G.shape[1])
        A = cho_solve(cho_factor(normal), P.T).T @ G.T  # α = G (GᵀG + λI)⁻¹ p
        scores = np.empty((len(P), people.max(initial=-1) + 1))
        for c in range(scores.shape[1]):
            alpha, rows = A[:, people == c], G[people == c]
            residual = np.linalg.norm(P - alpha @ rows, axis=1)
            weight = np.linalg.norm(alpha, axis=1)
            scores[:, c] = -residual / np.maximum(weight, 1e-12)
        return scores[:, people].astype(np.float32)
