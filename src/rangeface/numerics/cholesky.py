"""Cholesky factorisation of small systems, for use inside kernels."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def factor(A):  # type: ignore[no-untyped-def]
    """Factor A = L Lᵀ in place; False where a pivot vanishes against its diagonal."""
    k = A.shape[0]
    for c in range(k):
        diagonal = A[c, c]
        for t in range(c):
            A[c, c] -= A[c, t] * A[c, t]
        if not A[c, c] > 1e-6 * diagonal:
            return False
        A[c, c] = np.sqrt(A[c, c])
        for r in range(c + 1, k):
            for t in range(c):
                A[r, c] -= A[r, t] * A[c, t]
            A[r, c] /= A[c, c]
    return True


@njit(cache=True, nogil=True)
def solve(L, y):  # type: ignore[no-untyped-def]
    """Solve L Lᵀ c = y in place."""
    k = y.size
    for r in range(k):
        for t in range(r):
            y[r] -= L[r, t] * y[t]
        y[r] /= L[r, r]
    for r in range(k - 1, -1, -1):
        for t in range(r + 1, k):
            y[r] -= L[t, r] * y[t]
        y[r] /= L[r, r]
