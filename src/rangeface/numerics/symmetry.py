"""Mirror symmetry of a frontal depth image."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from rangeface.numerics import cholesky, gaussian

SCALE_MM = 4.0
"""Residual of the mirror image at which a pixel begins not to count, mm."""

YAW = 0.03
"""How far, rad, a registered face is expected to be still turned."""


def mirror_line(
    depth: ArrayLike, origin: tuple[float, float], *, pitch: float, iterations: int = 10
) -> tuple[float, float]:
    r"""The line of a frontal depth image about which it is most nearly its own mirror image.

    .. math:: \min_{c, φ, k} \sum_p ρ\bigl(f(p) - f(M p) - 2 k s\bigr) + (k / σ_k)^2, \qquad
              s = n·p - c, \quad M p = p - 2 s n, \quad n = (\cos φ, \sin φ)

    Parameters
    ----------
    depth : (H, W) array_like
        Depth, mm, NaN where invalid.
    origin : tuple of float
        Column and row from which the offset is counted, px: the nose tip.
    pitch : float
        Edge of a pixel, mm.
    iterations : int
        Gauss–Newton steps.

    Returns
    -------
    offset : float
        c, mm: distance of the line from the origin, to the right.
    roll : float
        φ, rad: the line runs along (−sin φ, cos φ).

    Notes
    -----
    k takes up what is left of the yaw. A rounded head that is shifted looks like one that is
    turned, so k is held near 0 (σ_k = `YAW`). ρ is Geman and McClure's with a scale of
    `SCALE_MM`: hair and holes do not count.

    Examples
    --------
    >>> y, x = np.mgrid[-20:21, -15:16] * 2.0
    >>> face = (x - 3) ** 2 / 160 + y**2 / 300 - 15 * np.exp(-((x - 3) ** 2 + y**2) / 200)
    >>> round(mirror_line(face, (15, 20), pitch=2.0)[0])
    3
    """
    z = gaussian.smooth(np.asarray(depth, np.float32), 1.0)
    c, phi = _mirror_line(z, origin[0], origin[1], pitch, iterations)
    return float(c), float(phi)


# ── kernels ──────────────────────────────────────────────────────────────────────────────


@njit(cache=True, nogil=True)
def _mirror_line(f, u0, v0, pitch, iterations):  # type: ignore[no-untyped-def]
    c = phi = k = 0.0
    A, b = np.empty((3, 3)), np.empty(3)
    for _ in range(iterations):
        _mirror_equations(f, u0, v0, pitch, c, phi, k, A, b)
        A[2, 2] += 1.0 / YAW**2
        b[2] += k / YAW**2
        if not cholesky.factor(A):
            break
        cholesky.solve(A, b)
        c, phi, k = c - b[0], phi - b[1], k - b[2]
        if abs(b[0]) < 0.01 and abs(b[1]) < 1e-4:
            break
    return c, phi


@njit(cache=True, nogil=True)
def _mirror_equations(f, u0, v0, pitch, c, phi, k, A, b):  # type: ignore[no-untyped-def]
    """Normal equations of (c, φ, k), one residual a pixel right of the line."""
    height, width = f.shape
    nx, ny = np.cos(phi), np.sin(phi)
    per_mm = 1.0 / pitch
    a00 = a01 = a02 = a11 = a12 = a22 = b0 = b1 = b2 = 0.0
    for v in range(0, height, 2):  # a quarter of the pixels: plenty for three numbers
        y = (v - v0) * pitch
        for u in range(0, width, 2):
            x = (u - u0) * pitch
            s = nx * x + ny * y - c
            mu, mv = u - 2.0 * s * nx * per_mm, v - 2.0 * s * ny * per_mm
            if not (s > 0.0 and 0.0 <= mu < width - 1 and 0.0 <= mv < height - 1):
                continue
            i, j = int(mu), int(mv)
            p, q = mu - i, mv - j
            f00, f01, f10, f11 = f[j, i], f[j, i + 1], f[j + 1, i], f[j + 1, i + 1]
            fx = ((f01 - f00) * (1.0 - q) + (f11 - f10) * q) * per_mm
            fy = ((f10 - f00) * (1.0 - p) + (f11 - f01) * p) * per_mm
            mirrored = f00 + p * (f01 - f00) + q * (f10 - f00) + p * q * (f00 - f01 - f10 + f11)
            residual = f[v, u] - mirrored - 2.0 * k * s
            if residual != residual:
                continue
            weight = 1.0 / (1.0 + (residual / SCALE_MM) ** 2) ** 2
            # derivatives of the residual by c, φ, k; n'·p is ∂s/∂φ
            turn, across = -ny * x + nx * y, fx * nx + fy * ny
            dc = 2.0 * k - 2.0 * across
            dphi = 2.0 * turn * across + 2.0 * s * (nx * fy - ny * fx) - 2.0 * k * turn
            dk = -2.0 * s
            wc, wphi, wk = weight * dc, weight * dphi, weight * dk
            a00, a01, a02 = a00 + wc * dc, a01 + wc * dphi, a02 + wc * dk
            a11, a12, a22 = a11 + wphi * dphi, a12 + wphi * dk, a22 + wk * dk
            b0, b1, b2 = b0 + wc * residual, b1 + wphi * residual, b2 + wk * residual
    A[0, 0], A[0, 1], A[0, 2] = a00, a01, a02
    A[1, 0], A[1, 1], A[1, 2] = a01, a11, a12
    A[2, 0], A[2, 1], A[2, 2] = a02, a12, a22
    b[0], b[1], b[2] = b0, b1, b2
