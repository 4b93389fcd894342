"""Matching of profiles by Pearson's coefficient."""

from __future__ import annotations

from typing import Self

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from rangeface.classify._base import Float32, Matcher
from rangeface.errors import ParameterError

_FAST = {"contract", "reassoc", "arcp", "nsz"}


class _ProfileMatcher(Matcher):
    """Brings profiles to mean 0 and length 1; nothing is learned."""

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Check profiles X (N, m) in rows; y is ignored."""
        self._samples(X)
        self._check_parameters()
        return self

    def transform(self, X: ArrayLike) -> Float32:
        """Profiles (n, m) less their mean, of unit length: (n, m) float32; 0 where constant.

        Raises
        ------
        ParameterError
            A value is not finite, or the width is not the fitted one.
        """
        Y = self._fitted_samples(X).astype(np.float64)
        spread = np.ptp(Y, axis=1, keepdims=True)
        Y -= Y.mean(axis=1, keepdims=True)
        length = np.linalg.norm(Y, axis=1, keepdims=True)
        varies = (spread > 0) & (length > 0)
        return np.where(varies, Y / np.where(varies, length, 1.0), 0.0).astype(np.float32)

    def _check_parameters(self) -> None:
        raise NotImplementedError


class PearsonMatcher(_ProfileMatcher):
    r"""Pearson's product-moment correlation of two profiles, at the best of several shifts.

    .. math::
        p(X, Y) = \frac{\operatorname{cov}(X, Y)}{\sqrt{\operatorname{var}X}
        \sqrt{\operatorname{var}Y}}, \quad
        \operatorname{cov}(X, Y) = E[(X - EX)(Y - EY)] \qquad (3.16, 3.17)

    Parameters
    ----------
    max_shift : int
        ≥ 0: one profile may be moved along the other by so many samples; the coefficient is
        taken over the samples that overlap, at least half of them. 0 is (3.16) itself.

    Raises
    ------
    ParameterError
        `max_shift` is negative, or a sample is not finite.

    Notes
    -----
    (3.16) is printed with a misplaced square root, √(var X · √(var Y)); the two are separate
    factors. The coefficient with a constant profile is 0.

    References
    ----------
    K. Pearson, Proc. R. Soc. Lond. 58, 1895, doi:10.1098/rspl.1895.0041.

    Examples
    --------
    >>> bump = np.array([[0.0, 0.0, 1.0, 3.0, 1.0, 0.0, 0.0, 0.0]])
    >>> for shift in (0, 2):
    ...     matcher = PearsonMatcher(max_shift=shift).fit(bump)
    ...     moved = matcher.transform(np.roll(bump, 2))
    ...     round(float(matcher.similarity(moved, matcher.transform(bump))[0, 0]), 3)
    -0.27
    1.0
    """

    def __init__(self, *, max_shift: int = 0) -> None:
        self.max_shift = max_shift

    def similarity(self, probes: ArrayLike, gallery: ArrayLike) -> Float32:
        """Coefficients −1 … 1 of transformed profiles (n, m) and (k, m): (n, k) float32."""
        P = np.ascontiguousarray(probes, dtype=np.float32)
        G = np.ascontiguousarray(gallery, dtype=np.float32)
        scores = np.empty((len(P), len(G)), dtype=np.float32)
        _best_shift(P, G, min(self.max_shift, P.shape[1] // 2), scores)
        return scores

    def _check_parameters(self) -> None:
        if self.max_shift < 0:
            raise ParameterError(f"max_shift: must be ≥ 0 samples, got {self.max_shift}")


class WarpedPearsonMatcher(_ProfileMatcher):
    """Pearson's coefficient of two profiles after one is stretched along the other.

    The profiles are aligned by dynamic time warping (least sum of squared differences within a
    band), and the coefficient is taken over the pairs of samples on the warping path.

    Parameters
    ----------
    band : int
        ≥ 0: samples of one profile may meet samples of the other at most so far away.

    Raises
    ------
    ParameterError
        `band` is negative, or a sample is not finite.

    Notes
    -----
    O(m · band) a pair. With band 0 it is `PearsonMatcher` without shift.

    References
    ----------
    H. Sakoe, S. Chiba, IEEE Trans. ASSP 26(1), 1978, doi:10.1109/TASSP.1978.1163055.

    Examples
    --------
    >>> profile = np.array([[0.0, 1.0, 3.0, 1.0, 0.0, 0.0]])
    >>> stretched = np.array([[0.0, 1.0, 3.0, 3.0, 1.0, 0.0]])
    >>> for band in (0, 1):
    ...     matcher = WarpedPearsonMatcher(band=band).fit(profile)
    ...     P, G = matcher.transform(stretched), matcher.transform(profile)
    ...     round(float(matcher.similarity(P, G)[0, 0]), 2)
    0.79
    1.0
    """

    def __init__(self, *, band: int = 3) -> None:
        self.band = band

    def similarity(self, probes: ArrayLike, gallery: ArrayLike) -> Float32:
        """Coefficients −1 … 1 of transformed profiles (n, m) and (k, m): (n, k) float32."""
        P = np.ascontiguousarray(probes, dtype=np.float32)
        G = np.ascontiguousarray(gallery, dtype=np.float32)
        scores = np.empty((len(P), len(G)), dtype=np.float32)
        _warped(P, G, min(self.band, P.shape[1]), scores)
        return scores

    def _check_parameters(self) -> None:
        if self.band < 0:
            raise ParameterError(f"band: must be ≥ 0 samples, got {self.band}")


@njit(cache=True, nogil=True, fastmath=_FAST)
def _correlation(n, sx, sy, sxx, syy, sxy):  # type: ignore[no-untyped-def]
    vx, vy = sxx - sx * sx / n, syy - sy * sy / n
    if vx <= 1e-12 * sxx or vy <= 1e-12 * syy:
        return 0.0
    return (sxy - sx * sy / n) / np.sqrt(vx * vy)


@njit(cache=True, nogil=True, fastmath=_FAST)
def _best_shift(P, G, max_shift, out):  # type: ignore[no-untyped-def]
    m = P.shape[1]
    for i in range(P.shape[0]):
        for j in range(G.shape[0]):
            best = -1.0
            for shift in range(-max_shift, max_shift + 1):
                first = max(0, shift)
                n = m - abs(shift)
                sx = sy = sxx = syy = sxy = 0.0
                for k in range(n):
                    x, y = float(P[i, first + k]), float(G[j, first - shift + k])
                    sx, sy = sx + x, sy + y
                    sxx, syy, sxy = sxx + x * x, syy + y * y, sxy + x * y
                best = max(best, _correlation(n, sx, sy, sxx, syy, sxy))
            out[i, j] = best


@njit(cache=True, nogil=True)
def _warped(P, G, band, out):  # type: ignore[no-untyped-def]
    m = P.shape[1]
    cost = np.empty((m + 1, m + 1))
    for i in range(P.shape[0]):
        for j in range(G.shape[0]):
            cost[:] = np.inf
            cost[0, 0] = 0.0
            for a in range(1, m + 1):
                for b in range(max(1, a - band), min(m, a + band) + 1):
                    step = min(cost[a - 1, b - 1], cost[a - 1, b], cost[a, b - 1])
                    cost[a, b] = step + (P[i, a - 1] - G[j, b - 1]) ** 2
            out[i, j] = _along_path(cost, P[i], G[j])


@njit(cache=True, nogil=True)
def _along_path(cost, p, g):  # type: ignore[no-untyped-def]
    a = b = len(p)
    n = 0
    sx = sy = sxx = syy = sxy = 0.0
    while a > 0 and b > 0:
        x, y = float(p[a - 1]), float(g[b - 1])
        n += 1
        sx, sy = sx + x, sy + y
        sxx, syy, sxy = sxx + x * x, syy + y * y, sxy + x * y
        diagonal, up, left = cost[a - 1, b - 1], cost[a - 1, b], cost[a, b - 1]
        if diagonal <= up and diagonal <= left:
            a, b = a - 1, b - 1
        elif up <= left:
            a -= 1
        else:
            b -= 1
    return _correlation(n, sx, sy, sxx, syy, sxy)
