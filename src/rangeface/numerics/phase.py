"""Weighted least-squares phase unwrapping."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.fft import dctn, idctn

from rangeface.errors import ParameterError

Float64: TypeAlias = NDArray[np.float64]


def wrap(angle: ArrayLike) -> Float64:
    """Angles in [−π, π).

    Examples
    --------
    >>> wrap([0.5, 3.5, -3.5]).round(4)
    array([ 0.5   , -2.7832,  2.7832])
    """
    return np.asarray((np.asarray(angle, np.float64) + np.pi) % (2.0 * np.pi) - np.pi)


def unwrap(
    phase: ArrayLike, weight: ArrayLike, *, tolerance: float = 1e-4, max_iterations: int = 60
) -> Float64:
    r"""Surface whose differences are closest to the wrapped differences of a phase.

    .. math:: \min_φ \sum_{\text{edges } pq} w_{pq}
              \bigl(φ_q - φ_p - W(ψ_q - ψ_p)\bigr)^2, \qquad w_{pq} = \min(w_p, w_q)^2

    Parameters
    ----------
    phase : (H, W) array_like
        Wrapped phase ψ, rad; may be NaN where the weight is 0.
    weight : (H, W) array_like
        Confidence w ≥ 0, 0 where there is no phase; not all 0.
    tolerance : float
        Relative residual at which the conjugate gradients stop, > 0.
    max_iterations : int
        At which they stop in any case, ≥ 1.

    Returns
    -------
    (H, W) float64
        φ, rad, smooth across pixels without weight; its constant is such that the weighted
        circular mean of ψ − φ is 0.

    Raises
    ------
    ParameterError
        Shapes differ, a weight is negative or all are 0.

    Notes
    -----
    Conjugate gradients, preconditioned by the unweighted Poisson equation, which the cosine
    transform solves. Where the phase winds around a point (the nose tip of a normal field)
    no surface has its differences, and φ is the best compromise, not congruent to ψ.

    References
    ----------
    D. C. Ghiglia, L. A. Romero, JOSA A 11(1), 1994, doi:10.1364/JOSAA.11.000107.

    Examples
    --------
    >>> ramp = np.add.outer(np.zeros(4), 2.0 * np.arange(6))
    >>> bool(np.allclose(unwrap(wrap(ramp), np.ones((4, 6))) % (2 * np.pi), ramp % (2 * np.pi)))
    True
    """
    ψ, w = np.asarray(phase, np.float64), np.asarray(weight, np.float64)
    if ψ.shape != w.shape or ψ.ndim != 2:
        raise ParameterError(f"weight: shape {w.shape} does not match the phase's {ψ.shape}")
    if not (w >= 0).all() or not w.any():
        raise ParameterError("weight: must be ≥ 0 and not 0 everywhere")
    ψ = np.where(w > 0, ψ, 0.0)
    down = np.minimum(w[1:], w[:-1]) ** 2
    right = np.minimum(w[:, 1:], w[:, :-1]) ** 2

    def divergence(dy: Float64, dx: Float64) -> Float64:
        out = np.zeros_like(ψ)
        out[:-1] += down * dy
        out[1:] -= down * dy
        out[:, :-1] += right * dx
        out[:, 1:] -= right * dx
        return out

    def laplacian(φ: Float64) -> Float64:
        return divergence(np.diff(φ, axis=0), np.diff(φ, axis=1))

    target = divergence(wrap(np.diff(ψ, axis=0)), wrap(np.diff(ψ, axis=1)))
    φ = _conjugate_gradients(laplacian, target, tolerance, max_iterations)
    return np.asarray(φ + np.angle((w * np.exp(1j * (ψ - φ))).sum()))


def _poisson(right_side: Float64) -> Float64:
    """Solution of the unweighted Poisson equation with free borders, of mean 0."""
    spectrum = dctn(right_side, type=2, norm="ortho")
    rows, columns = (2.0 * np.cos(np.pi * np.arange(n) / n) - 2.0 for n in right_side.shape)
    eigenvalues = rows[:, None] + columns
    eigenvalues[0, 0] = 1.0
    spectrum = spectrum / eigenvalues
    spectrum[0, 0] = 0.0
    return np.asarray(idctn(spectrum, type=2, norm="ortho"))


def _conjugate_gradients(
    operator: Callable[[Float64], Float64], target: Float64, tolerance: float, max_iterations: int
) -> Float64:
    """Solve operator(φ) = target, both negative semi-definite with the constants as kernel."""
    φ = np.zeros_like(target)
    residual = target.copy()
    enough = tolerance * np.linalg.norm(target)
    direction, energy = np.zeros_like(target), 1.0
    for _ in range(max_iterations):
        if np.linalg.norm(residual) <= enough:
            break
        z = _poisson(residual)
        new_energy = float((residual * z).sum())
        direction = z + (new_energy / energy) * direction
        energy = new_energy
        step = operator(direction)
        length = energy / float((direction * step).sum())
        φ += length * direction
        residual -= length * step
    return φ
