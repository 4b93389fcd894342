"""The span of the training samples: small coordinates in which scatter matrices are solved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular

from rangeface.errors import DegenerateError

Array = NDArray[Any]

ROUNDING = 100  # a pivot below this many eps of the largest one is rounding, not variation


@dataclass(frozen=True)
class Span:
    r"""Centred samples in an orthonormal basis V of the space that they span.

    .. math:: X_c = Z V^T, \quad V^T V = I

    Any scatter matrix of the pixels is V S V^T with S of the coordinates Z, so an eigenproblem
    of m pixels becomes one of r ≤ min(N − 1, m) coordinates (the Gram trick), and the training
    null space (eigenvalue 0) is left out.

    Parameters
    ----------
    mean : (m,) array
        Mean sample μ.
    coordinates : (N, r) array
        Z.
    basis_samples : (r, m) array or None
        Centred samples B with V = Bᵀ L⁻ᵀ; None where V is the identity (N > m).
    factor : (r, r) array or None
        Lower triangle L.
    """

    mean: Array
    coordinates: Array
    basis_samples: Array | None = None
    factor: Array | None = None

    def lift(self, directions: Array) -> Array:
        """Directions (r, D) of the coordinates as rows (D, m) in pixel space."""
        if self.basis_samples is None or self.factor is None:
            return np.ascontiguousarray(directions.T)
        weights = solve_triangular(self.factor, directions, trans="T", lower=True)
        return np.ascontiguousarray(weights.T @ self.basis_samples)


def span(X: Array, *, dtype: type = np.float64) -> Span:
    """Coordinates of the samples in their own span.

    Parameters
    ----------
    X : (N, m) array
        Samples in rows.
    dtype : type
        float32 is enough for criteria that add scatters (PCA, MLDA): what it loses of the
        spectrum has no weight there. Quotients of scatters (LDA) need float64.

    Returns
    -------
    Span
        Mean, coordinates, and the way back.

    Raises
    ------
    DegenerateError
        All samples are alike, or there is only one.

    Notes
    -----
    Pivoted Cholesky of the Gram matrix, N³/3 operations: K = X_c X_cᵀ = L Lᵀ, and the first r
    pivots are the samples that carry the basis. Duplicates and the centring fall out as rank.
    """
    X = np.asarray(X, dtype=dtype)
    mean = X.mean(axis=0)
    Xc = X - mean
    scale = float(np.abs(Xc).max(initial=0.0))
    if len(X) < 2 or scale <= 8 * np.finfo(dtype).eps * float(np.abs(X).max(initial=0.0)):
        raise DegenerateError(f"the {len(X)} samples are all alike (n_samples = {len(X)})")
    if len(X) > X.shape[1]:
        return Span(mean, Xc)
    Z, pivots, L = gram_span(Xc @ Xc.T)
    return Span(mean, Z, Xc[pivots], L)


def gram_span(gram: Array) -> tuple[Array, Array, Array]:
    """Coordinates Z with K = Z Zᵀ, the samples that carry the basis, and their factor L.

    K is the Gram matrix of centred samples. Row p of L is the coordinates of basis sample p, so
    any sample x with products k = ⟨x, basis⟩ has the coordinates L⁻¹k.
    """
    pstrf = lapack.spstrf if gram.dtype == np.float32 else lapack.dpstrf
    tolerance = ROUNDING * np.finfo(gram.dtype).eps * gram.diagonal().max()
    L, order, rank, _ = pstrf(gram, tol=tolerance, lower=1)
    rank = min(rank, len(gram) - 1)  # centring costs one dimension
    L, pivots = np.tril(L)[:, :rank], order - 1
    Z = np.empty_like(L)
    Z[pivots] = L
    return Z, pivots[:rank], L[:rank]


def scatter_within(Z: Array, labels: Array) -> Array:
    r"""Deviations from the class means; their product is S_W (eq. 3.13): (N, r)."""
    return Z - class_means(Z, labels)[labels]


def scatter_between(Z: Array, labels: Array) -> Array:
    r"""Class means from the grand mean, times √N_j; their product is S_B (eq. 3.14): (C, r)."""
    counts = np.bincount(labels).astype(Z.dtype)
    return np.sqrt(counts)[:, None] * (class_means(Z, labels) - Z.mean(axis=0))


def class_means(Z: Array, labels: Array) -> Array:
    """Mean of each class, (C, r); labels are 0 … C − 1."""
    sums = np.zeros((labels.max() + 1, Z.shape[1]), dtype=Z.dtype)
    np.add.at(sums, labels, Z)
    return sums / np.bincount(labels).astype(Z.dtype)[:, None]


def oriented(components: Array) -> Array:
    """Rows with the sign that makes the entry of largest magnitude positive."""
    largest = np.take_along_axis(components, np.abs(components).argmax(axis=1)[:, None], axis=1)
    return components * np.where(largest < 0, -1, 1).astype(components.dtype)
