r"""Curvature of depth images.

A surface z(x, y) with slopes p, q and second derivatives r = z_xx, s = z_xy, t = z_yy has

.. math:: K = \frac{rt - s^2}{(1 + p^2 + q^2)^2}, \qquad
          H = \frac{(1 + q^2) r - 2pqs + (1 + p^2) t}{2 (1 + p^2 + q^2)^{3/2}}

(do Carmo, Differential Geometry of Curves and Surfaces, §3-3). Depth grows away from the
camera, so with these signs a surface that bulges **towards** the camera has H > 0.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import localfit

Float32: TypeAlias = NDArray[np.float32]
Float64: TypeAlias = NDArray[np.float64]

KINDS = ("gaussian", "mean", "maximal", "minimal", "shape_index", "curvedness")
"""What `of_kind` knows to make of K and H."""


def by_differences(depth: ArrayLike, pitch: float) -> tuple[Float64, Float64]:
    """Gaussian and mean curvature by second differences over 3 × 3 pixels.

    Parameters
    ----------
    depth : (…, H, W) array_like
        Depth, NaN where invalid.
    pitch : float
        Edge of a pixel, in the unit of the depth.

    Returns
    -------
    K, H : (…, H, W) float64
        Per squared and per unit of length; NaN where one of the nine pixels is missing.

    Notes
    -----
    The noisy baseline of the paper's figure 5: noise σ of the depth becomes √6 σ / pitch² in
    a second derivative.

    Examples
    --------
    >>> y, x = np.mgrid[-1:2, -1:2]
    >>> K, H = by_differences(0.5 * (0.02 * x**2 + 0.01 * y**2), pitch=1.0)
    >>> round(float(K[1, 1]), 6), round(float(H[1, 1]), 6)
    (0.0002, 0.015)
    """
    z = np.asarray(depth, np.float64)
    frame = [(0, 0)] * (z.ndim - 2) + [(1, 1), (1, 1)]
    z = np.pad(z, frame, constant_values=np.nan)

    def at(dv: int, du: int) -> Float64:
        height, width = z.shape[-2:]
        return z[..., 1 + dv : height - 1 + dv, 1 + du : width - 1 + du]

    p, q = (at(0, 1) - at(0, -1)) / (2 * pitch), (at(1, 0) - at(-1, 0)) / (2 * pitch)
    r = (at(0, 1) - 2 * at(0, 0) + at(0, -1)) / pitch**2
    t = (at(1, 0) - 2 * at(0, 0) + at(-1, 0)) / pitch**2
    s = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * pitch**2)
    return gaussian_and_mean(np.stack([p, q, r, s, t], axis=-1))


def by_fit(
    depth: ArrayLike, pitch: float, *, radius: float, sigma: ArrayLike | None = None
) -> tuple[Float64, Float64]:
    """Gaussian and mean curvature of the least-squares quadric over a disc.

    Parameters
    ----------
    depth : (…, H, W) array_like
        Depth, NaN where invalid.
    pitch : float
        Edge of a pixel, in the unit of the depth.
    radius : float
        Radius of the disc, in the same unit, √2 to 15 pixels.
    sigma : (…, H, W) array_like, optional
        Standard deviation of the depth; weights are 1/σ².

    Returns
    -------
    K, H : (…, H, W) float64
        NaN where the disc determines no quadric.

    Raises
    ------
    ParameterError
        The disc is smaller than √2 or larger than 15 pixels.

    Examples
    --------
    >>> y, x = np.mgrid[-3:4, -3:4]
    >>> K, H = by_fit(0.5 * (0.02 * x**2 + 0.01 * y**2), 1.0, radius=3.0)
    >>> round(float(K[3, 3]), 6), round(float(H[3, 3]), 6)
    (0.0002, 0.015)
    """
    fitted = localfit.fit(depth, sigma=sigma, radius_px=_radius_px(radius, pitch), degree=2)
    return gaussian_and_mean(fitted[..., 1:] / _scale(pitch))


def by_fit_with_sigma(
    depth: ArrayLike, pitch: float, *, radius: float, sigma: ArrayLike
) -> tuple[Float64, Float64, Float64]:
    r"""Curvature as by `by_fit`, and its covariance to first order.

    .. math:: Σ_{KH} = J Σ_{pqrst} J^T

    Parameters
    ----------
    depth, pitch, radius
        As for `by_fit`.
    sigma : (…, H, W) array_like
        Standard deviation of the depth, independent between pixels.

    Returns
    -------
    K, H : (…, H, W) float64
    covariance : (…, H, W, 2, 2) float64
        Of (K, H).

    Raises
    ------
    ParameterError
        As for `by_fit`.

    Examples
    --------
    >>> K, H, C = by_fit_with_sigma(np.zeros((7, 7)), 1.0, radius=3.0, sigma=np.ones((7, 7)))
    >>> round(float(np.sqrt(C[3, 3, 1, 1])), 4)
    0.133
    """
    fitted, covariance = localfit.fit_with_covariance(
        depth, sigma=sigma, radius_px=_radius_px(radius, pitch), degree=2
    )
    scale = _scale(pitch)
    slopes = fitted[..., 1:] / scale
    spread = covariance[..., 1:, 1:] / (scale[:, None] * scale)
    J = _jacobian(slopes)
    K, H = gaussian_and_mean(slopes)
    return K, H, J @ spread @ np.swapaxes(J, -1, -2)


def gaussian_and_mean(slopes: ArrayLike) -> tuple[Float64, Float64]:
    """K and H of the derivatives (p, q, r, s, t), last axis."""
    p, q, r, s, t = np.moveaxis(np.asarray(slopes, np.float64), -1, 0)
    g = 1.0 + p * p + q * q
    K = (r * t - s * s) / g**2
    H = ((1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t) / (2.0 * g**1.5)
    return K, H


def of_kind(kind: str, K: ArrayLike, H: ArrayLike) -> Float64:
    r"""Another measure of curvature, from Gaussian and mean curvature.

    .. math:: k_{1,2} = H ± \sqrt{H^2 - K}, \quad
              S = \tfrac{2}{π} \arctan\frac{k_1 + k_2}{k_1 - k_2}, \quad
              C = \sqrt{(k_1^2 + k_2^2) / 2} = \sqrt{2 H^2 - K}

    Parameters
    ----------
    kind : {"gaussian", "mean", "maximal", "minimal", "shape_index", "curvedness"}
        K, H, k₁, k₂, S in [−1, 1] (−1 cup, 0 saddle, +1 cap), C.
    K, H : array_like
        Gaussian and mean curvature.

    Returns
    -------
    float64 array
        Per length for H, k and C, per squared length for K.

    Raises
    ------
    ParameterError
        The kind is unknown.

    Notes
    -----
    On a plane the shape index is not defined; 0 is given there.

    References
    ----------
    J. J. Koenderink, A. J. van Doorn, Image and Vision Computing 10(8), 1992,
    doi:10.1016/0262-8856(92)90076-F.

    Examples
    --------
    >>> [round(float(of_kind(k, 0.01, 0.1)), 4) for k in KINDS]  # a sphere of radius 10
    [0.01, 0.1, 0.1, 0.1, 1.0, 0.1]
    """
    K, H = np.asarray(K, np.float64), np.asarray(H, np.float64)
    half = np.sqrt(np.maximum(H * H - K, 0.0))  # rounding may take it below 0 at umbilics
    measures = {
        "gaussian": K,
        "mean": H,
        "maximal": H + half,
        "minimal": H - half,
        "shape_index": 2.0 / np.pi * np.arctan2(H, half),
        "curvedness": np.sqrt(H * H + half * half),
    }
    if kind not in measures:
        raise ParameterError(f"kind: must be one of {KINDS}, got {kind!r}")
    return np.asarray(measures[kind])


def sigma_of_kind(kind: str, K: ArrayLike, H: ArrayLike, covariance: ArrayLike) -> Float64:
    """Standard deviation of a measure, from the covariance (…, 2, 2) of (K, H), to first order.

    Parameters
    ----------
    kind, K, H
        As for `of_kind`.
    covariance : (…, 2, 2) array_like
        As `by_fit_with_sigma` gives it.

    Returns
    -------
    float64 array
        In the unit of the measure; ∞ where the measure has no derivative (principal curvature
        and shape index at an umbilic, curvedness on a plane).

    Raises
    ------
    ParameterError
        The kind is unknown.

    Examples
    --------
    >>> float(sigma_of_kind("mean", 0.0, 0.1, [[1e-6, 0.0], [0.0, 4e-6]]))
    0.002
    """
    K, H = np.asarray(K, np.float64), np.asarray(H, np.float64)
    C = np.asarray(covariance, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        half = np.sqrt(np.maximum(H * H - K, 0.0))
        curvedness = np.sqrt(H * H + half * half)
        turn = 2.0 / np.pi / curvedness**2
        one, zero = np.ones_like(K), np.zeros_like(K)
        gradients = {  # ∂/∂K, ∂/∂H
            "gaussian": (one, zero),
            "mean": (zero, one),
            "maximal": (-0.5 / half, 1.0 + H / half),
            "minimal": (0.5 / half, 1.0 - H / half),
            "shape_index": (turn * 0.5 * H / half, turn * (half - H * H / half)),
            "curvedness": (-0.5 / curvedness, 2.0 * H / curvedness),
        }
        if kind not in gradients:
            raise ParameterError(f"kind: must be one of {KINDS}, got {kind!r}")
        a, b = gradients[kind]
        variance = a * a * C[..., 0, 0] + 2 * a * b * C[..., 0, 1] + b * b * C[..., 1, 1]
    known = np.isfinite(C).all(axis=(-1, -2))
    return np.where(
        np.isfinite(variance), np.sqrt(np.abs(variance)), np.where(known, np.inf, np.nan)
    )


def _jacobian(slopes: ArrayLike) -> Float64:
    """∂(K, H)/∂(p, q, r, s, t), (…, 2, 5)."""
    p, q, r, s, t = np.moveaxis(np.asarray(slopes, np.float64), -1, 0)
    g = 1.0 + p * p + q * q
    K, H = gaussian_and_mean(slopes)
    c = 1.0 / (2.0 * g**1.5)
    dK = [-4.0 * p * K / g, -4.0 * q * K / g, t / g**2, -2.0 * s / g**2, r / g**2]
    dH = [
        c * (2.0 * p * t - 2.0 * q * s) - 3.0 * p * H / g,
        c * (2.0 * q * r - 2.0 * p * s) - 3.0 * q * H / g,
        c * (1.0 + q * q),
        -2.0 * c * p * q,
        c * (1.0 + p * p),
    ]
    return np.stack([np.stack(dK, axis=-1), np.stack(dH, axis=-1)], axis=-2)


def _radius_px(radius: float, pitch: float) -> float:
    if not np.sqrt(2.0) <= radius / pitch <= 15.0:
        raise ParameterError(
            f"radius_mm: {radius} mm is {radius / pitch:.2f} px; a quadric needs 1.42 … 15 px"
        )
    return radius / pitch


def _scale(pitch: float) -> Float64:
    """Pixels to lengths, for (p, q, r, s, t)."""
    return np.array([pitch, pitch, pitch**2, pitch**2, pitch**2])
