r"""How well two face surfaces fit after the small motion that registration left between them.

A surface is a depth image z(x, y) on a square orthographic grid, with the inverse variance of
each pixel (0: nothing measured there). Minimised over the motion (R, t) is

.. math:: E = \frac{1}{K} \sum_k ρ(r_k), \quad
    r_k = n_k · (q_k - R p_k - t), \quad ρ(r) = \frac{r^2}{r^2 + s^2 + σ_p^2 + σ_g^2}

over the K measured pixels p of the probe, with the gallery's point q and normal n under the
moved p. ρ is the Geman–McClure loss; its scale adds the noise of both pixels, so that a noisy
pixel says less. A pixel under which the gallery has nothing costs `missing`: otherwise a
gallery with little surface would fit everybody.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rangeface.numerics import cholesky

Float32 = NDArray[np.float32]

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}


@njit(cache=True, nogil=True, fastmath=_FASTMATH, inline="always")
def _pair(P, G, row, col, R, t, pitch, s2):  # type: ignore[no-untyped-def]
    """Status (0 unmeasured, 1 no counterpart, 2 paired), residual, scale², normal, moved point."""
    none = np.float32(0.0)
    one = np.float32(1.0)
    certainty = P[row, col, 1]
    if not certainty > none:
        return 0, none, one, none, none, one, none, none, none
    half = np.float32(0.5)
    rows, cols = np.float32(G.shape[0] - 1), np.float32(G.shape[1] - 1)
    cx, cy = half * cols, half * rows
    per_mm = one / pitch
    px, py, pz = (np.float32(col) - cx) * pitch, (np.float32(row) - cy) * pitch, P[row, col, 0]
    x = R[0, 0] * px + R[0, 1] * py + R[0, 2] * pz + t[0]
    y = R[1, 0] * px + R[1, 1] * py + R[1, 2] * pz + t[1]
    z = R[2, 0] * px + R[2, 1] * py + R[2, 2] * pz + t[2]
    u, v = x * per_mm + cx, y * per_mm + cy
    if not (u >= none and v >= none and u < cols and v < rows):
        return 1, none, one, none, none, one, x, y, z
    i, j = np.uint32(v), np.uint32(u)
    du, dv = u - np.float32(j), v - np.float32(i)
    a, b, c, d = G[i, j, 0], G[i, j + 1, 0], G[i + 1, j, 0], G[i + 1, j + 1, 0]
    least = min(min(G[i, j, 1], G[i, j + 1, 1]), min(G[i + 1, j, 1], G[i + 1, j + 1, 1]))
    if not least > none:
        return 1, none, one, none, none, one, x, y, z
    gx = ((b - a) + dv * ((d - c) - (b - a))) * per_mm
    gy = ((c - a) + du * ((d - b) - (c - a))) * per_mm
    length = one / np.sqrt(one + gx * gx + gy * gy)
    height = a + du * (b - a) + dv * ((c - a) + du * ((d - c) - (b - a)))
    scale = s2 + (certainty + least) / (certainty * least)
    return 2, (height - z) * length, scale, -gx * length, -gy * length, length, x, y, z


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _normal_equations(P, G, where, R, t, pitch, s2, A, b):  # type: ignore[no-untyped-def]
    """Fill the normal equations of one Gauss–Newton step."""
    J = np.empty(6, np.float32)
    A[:] = 0.0
    b[:] = 0.0
    for k in range(where.shape[0]):
        status, r, scale, nx, ny, nz, x, y, z = _pair(
            P, G, where[k, 0], where[k, 1], R, t, pitch, s2
        )
        if status != 2:
            continue
        share = scale / (scale + r * r)
        w = share * share / scale
        J[0], J[1], J[2] = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
        J[3], J[4], J[5] = nx, ny, nz
        for m in range(6):
            wj = w * J[m]
            b[m] += wj * r
            for n in range(m + 1):
                A[m, n] += wj * J[n]


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _mean_loss(P, G, where, R, t, pitch, s2, missing):  # type: ignore[no-untyped-def]
    loss, count = np.float32(0.0), 0
    for k in range(where.shape[0]):
        status, r, scale, _, _, _, _, _, _ = _pair(P, G, where[k, 0], where[k, 1], R, t, pitch, s2)
        if status > 0:
            count += 1
            loss += r * r / (scale + r * r) if status == 2 else missing
    return loss / np.float32(count) if count > 0 else missing


@njit(cache=True, nogil=True)
def _step(A, b):  # type: ignore[no-untyped-def]
    """Solve the 6 × 6 normal equations, damped a trace: no pivot vanishes."""
    damping = 1e-3 * (A[3, 3] + A[4, 4] + A[5, 5]) + 1e-12
    L, x = A.astype(np.float64), b.astype(np.float64)
    for i in range(6):
        L[i, i] += damping * (1600.0 if i < 3 else 1.0)  # rotations act 40 mm away
    cholesky.factor(L)
    cholesky.solve(L, x)
    return x


@njit(cache=True, nogil=True)
def _fit(P, G, coarse, fine, pitch, s2, missing, iterations, limit, R, t, A, b):  # type: ignore[no-untyped-def]
    """Loss of the best small motion; R and t are working space and hold it afterwards."""
    R[:] = 0.0
    R[0, 0] = R[1, 1] = R[2, 2] = 1.0
    t[:] = 0.0
    for _ in range(iterations):
        _normal_equations(P, G, coarse, R, t, pitch, s2, A, b)
        x = _step(A, b)
        angle = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
        shift = math.sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5])
        x *= min(1.0, limit / max(40.0 * angle + shift, 1e-9))  # no step beyond the small motion
        a, c, e = x[0], x[1], x[2]
        scale = 1.0 / (1.0 + 0.25 * (a * a + c * c + e * e))  # Cayley: a rotation without sines
        for k in range(3):
            r0, r1, r2 = R[0, k], R[1, k], R[2, k]
            h0 = r0 + 0.5 * (c * r2 - e * r1)
            h1 = r1 + 0.5 * (e * r0 - a * r2)
            h2 = r2 + 0.5 * (a * r1 - c * r0)
            R[0, k] = r0 + scale * (c * h2 - e * h1)
            R[1, k] = r1 + scale * (e * h0 - a * h2)
            R[2, k] = r2 + scale * (a * h1 - c * h0)
        t0, t1, t2 = t[0], t[1], t[2]
        t[0] = t0 + c * t2 - e * t1 + x[3]
        t[1] = t1 + e * t0 - a * t2 + x[4]
        t[2] = t2 + a * t1 - c * t0 + x[5]
    return _mean_loss(P, G, fine, R, t, pitch, s2, missing)


@njit(cache=True, nogil=True)
def _losses(probes, gallery, coarse, fine, pitch, s2, missing, iterations, limit, out):  # type: ignore[no-untyped-def]
    R, t = np.empty((3, 3), np.float32), np.empty(3, np.float32)
    A, b = np.empty((6, 6), np.float32), np.empty(6, np.float32)
    for i in range(probes.shape[0]):
        for j in range(gallery.shape[0]):
            out[i, j] = _fit(
                probes[i], gallery[j], coarse, fine, pitch, s2, missing, iterations, limit,
                R, t, A, b,
            )  # fmt: skip


def surface_losses(
    probes: Float32,
    gallery: Float32,
    pixels: NDArray[np.integer],
    *,
    pitch_mm: float,
    scale_mm: float = 3.0,
    missing: float = 0.6,
    iterations: int = 4,
    limit_mm: float = 6.0,
) -> Float32:
    """Mean loss of every probe on every gallery surface after the best small motion.

    Parameters
    ----------
    probes, gallery : (n, H, W, 2) and (m, H, W, 2) float32
        Depth, mm, and its inverse variance, 1/mm²; 0 where nothing was measured.
    pixels : (k, 2) array of int
        Rows and columns of the region that is compared; the alignment uses every third.
    pitch_mm : float
        Edge of a pixel.
    scale_mm : float
        s: residuals well beyond it count as unlike, whatever their size.
    missing : float
        Loss of a probe's pixel without a counterpart, 0 … 1.
    iterations : int
        Gauss–Newton steps.
    limit_mm : float
        Longest step: the rotation 40 mm away plus the translation.

    Returns
    -------
    (n, m) float32
        0 = the same surface, 1 = nothing fits.
    """
    where = np.ascontiguousarray(pixels, np.uint32)
    out = np.empty((len(probes), len(gallery)), np.float32)
    _losses(
        probes, gallery, np.ascontiguousarray(where[::3]), where, np.float32(pitch_mm),
        np.float32(scale_mm**2), np.float32(missing), iterations, float(limit_mm), out,
    )  # fmt: skip
    return out


@njit(cache=True, nogil=True)
def _residuals(P, G, coarse, everywhere, pitch, s2, iterations, limit, out):  # type: ignore[no-untyped-def]
    R, t = np.empty((3, 3), np.float32), np.empty(3, np.float32)
    A, b = np.empty((6, 6), np.float32), np.empty(6, np.float32)
    one = np.float32(1.0)
    _fit(P, G, coarse, coarse, pitch, s2, one, iterations, limit, R, t, A, b)
    for k in range(everywhere.shape[0]):
        row, col = everywhere[k, 0], everywhere[k, 1]
        status, r, _, _, _, _, _, _, _ = _pair(P, G, row, col, R, t, pitch, s2)
        out[row, col] = r if status == 2 else np.nan


def surface_residuals(
    probe: Float32,
    gallery: Float32,
    pixels: NDArray[np.integer],
    *,
    pitch_mm: float,
    scale_mm: float = 3.0,
    iterations: int = 8,
    limit_mm: float = 6.0,
) -> Float32:
    """Where two surfaces differ after the best small motion of `surface_losses`.

    Parameters
    ----------
    probe, gallery : (H, W, 2) float32
        Depth, mm, and its inverse variance, 1/mm².
    pixels : (k, 2) array of int
        Rows and columns that are aligned.
    pitch_mm, scale_mm, iterations, limit_mm
        As for `surface_losses`.

    Returns
    -------
    (H, W) float32
        Distance of the gallery's surface behind the probe's, along the normal, mm; NaN where
        one of them has none.
    """
    where = np.ascontiguousarray(pixels, np.uint32)
    everywhere = np.argwhere(np.ones(probe.shape[:2], bool)).astype(np.uint32)
    out = np.full(probe.shape[:2], np.nan, np.float32)
    _residuals(
        np.ascontiguousarray(probe, np.float32), np.ascontiguousarray(gallery, np.float32), where,
        everywhere, np.float32(pitch_mm), np.float32(scale_mm**2), iterations, float(limit_mm), out,
    )  # fmt: skip
    return out
