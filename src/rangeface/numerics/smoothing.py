"""Smoothing of images with holes, weights and edges."""

from __future__ import annotations

from typing import TypeAlias

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

Image: TypeAlias = NDArray[np.float32]

# NaN marks invalid pixels, so `nnan` stays out
_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}


def gaussian_kernel(sigma_px: float) -> Image:
    """Sampled Gaussian that sums to 1, cut at three standard deviations.

    Parameters
    ----------
    sigma_px : float
        Standard deviation, px, > 0.

    Returns
    -------
    (2 r + 1,) float32
        r = max(1, round(3 σ)).

    Examples
    --------
    >>> gaussian_kernel(0.5).round(3)
    array([0.   , 0.106, 0.787, 0.106, 0.   ], dtype=float32)
    """
    radius = max(1, round(3.0 * sigma_px))
    return cv2.getGaussianKernel(2 * radius + 1, sigma_px, ktype=cv2.CV_32F).ravel()


def normalized_convolution(
    values: Image, confidence: Image, variance: Image | None, kernel: Image
) -> tuple[Image, Image | None, Image]:
    r"""Mean of an image under a kernel, each pixel weighted by its confidence.

    .. math:: I' = \frac{g * (C I)}{g * C}, \qquad
              \operatorname{var} I' = \frac{g^2 * (C^2 \operatorname{var} I)}{(g * C)^2}

    Parameters
    ----------
    values : (H, W) float32
        Finite wherever the confidence is not 0.
    confidence : (H, W) float32
        C ≥ 0; 0 = nothing known.
    variance : (H, W) float32, optional
        Of the values, which are taken as independent.
    kernel : (2 r + 1,) float32
        Separable kernel g.

    Returns
    -------
    mean : (H, W) float32
        NaN where no confidence is in reach.
    variance : (H, W) float32 or None
        Of the mean, where that of the values was given.
    mass : (H, W) float32
        g * C; outside the image C is 0.

    References
    ----------
    H. Knutsson, C.-F. Westin, CVPR 1993, doi:10.1109/CVPR.1993.341081.

    Examples
    --------
    >>> z, c = np.float32([[1, 9, 3]]), np.float32([[1, 0, 1]])
    >>> mean, _, _ = normalized_convolution(z, c, None, gaussian_kernel(1.0))
    >>> float(mean[0, 1])
    2.0
    """
    known = confidence > 0
    mass = blurred(confidence, kernel)
    safe: Image = np.where(mass > 0, mass, np.float32(np.nan))
    mean = blurred(np.where(known, confidence * values, np.float32(0)), kernel) / safe
    if variance is None:
        return mean, None, mass
    spread = np.where(known, confidence * confidence * variance, np.float32(0))
    return mean, blurred(spread, kernel * kernel) / (safe * safe), mass


def blurred(image: Image, kernel: Image) -> Image:
    """Convolution with a separable symmetric kernel; outside the image is 0."""
    return cv2.sepFilter2D(image, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_CONSTANT)


def gated_convolution(
    values: Image,
    confidence: Image,
    variance: Image | None,
    reference: Image,
    step: Image,
    kernel: Image,
) -> tuple[Image, Image | None, Image]:
    """Normalized convolution over those pixels that lie near a reference in value.

    A pixel q takes part in the mean at p if ``|values[q] - reference[p]| <= step[p]``: the
    surface on the far side of a depth discontinuity has no say.

    Parameters
    ----------
    values, confidence, variance : (H, W) float32
        As in `normalized_convolution`; a NaN value never takes part.
    reference : (H, W) float32
        The value around which p gathers; NaN gives NaN.
    step : (H, W) float32
        Half-width of the gate.
    kernel : (2 r + 1,) float32
        Separable kernel g.

    Returns
    -------
    mean, variance, mass : (H, W) float32
        As in `normalized_convolution`, over the pixels inside the gate.

    Examples
    --------
    >>> z = np.float32([[400, 402, 900]])
    >>> one, step = np.ones_like(z), np.full_like(z, 20)
    >>> mean, _, _ = gated_convolution(z, one, None, z, step, gaussian_kernel(9.0))
    >>> mean.round(1)
    array([[401., 401., 900.]], dtype=float32)
    """
    known = np.isfinite(values) & (confidence > 0)
    z = np.where(known, values, np.float32(0))
    C = np.where(known, confidence, np.float32(0))
    # the gate is shut where there is nothing to gather around
    gate = np.where(np.isfinite(reference), step, np.float32(-1))
    centre = np.nan_to_num(reference)
    mass, total = _gated_sums(z, C, centre, gate, kernel)
    safe: Image = np.where(mass > 0, mass, np.float32(np.nan))
    mean = centre + total / safe
    if variance is None:
        return mean, None, mass
    spread, _ = _gated_sums(z, C * C * np.where(known, variance, 0), centre, gate, kernel**2)
    return mean, spread / (safe * safe), mass


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _gated_sums(
    values: Image, weight: Image, centre: Image, gate: Image, kernel: Image
) -> tuple[Image, Image]:
    """Sums of g C and of g C (z − centre) over the pixels inside the gate."""
    rows, cols = values.shape
    radius = kernel.shape[0] // 2
    mass = np.zeros((rows, cols), dtype=np.float32)
    total = np.zeros((rows, cols), dtype=np.float32)
    w = np.empty(cols, dtype=np.float32)
    for y in range(rows):
        for dy in range(max(-radius, -y), min(radius, rows - 1 - y) + 1):
            for dx in range(max(-radius, 1 - cols), min(radius, cols - 1) + 1):
                g = kernel[dy + radius] * kernel[dx + radius]
                here, there = slice(max(0, -dx), min(cols, cols - dx)), max(0, dx)
                z, level = values[y + dy, there:], centre[y, here]
                _gated(z, level, gate[y, here], weight[y + dy, there:], g, w)
                _add(w, mass[y, here])
                _add_offset(w, z, level, total[y, here])
    return mass, total


# one short loop a purpose, each with few arrays: the compiler can prove that they do not overlap
# and use vectors; `level` keeps float32 exact at large depths


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _gated(z: Image, level: Image, gate: Image, C: Image, g: np.float32, w: Image) -> None:
    for x in range(len(level)):
        w[x] = g * C[x] if abs(z[x] - level[x]) <= gate[x] else np.float32(0.0)


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _add(w: Image, out: Image) -> None:
    for x in range(len(out)):
        out[x] += w[x]


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _add_scaled(w: Image, factor: np.float32, out: Image) -> None:
    for x in range(len(out)):
        out[x] += factor * w[x]


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _add_offset(w: Image, z: Image, level: Image, out: Image) -> None:
    for x in range(len(out)):
        out[x] += w[x] * (z[x] - level[x])


def local_planes(values: Image, confidence: Image, step: Image, kernel: Image) -> Image:
    """Value at every pixel of the plane fitted to its neighbours (moving least squares).

    Parameters
    ----------
    values, confidence, step, kernel
        As in `gated_convolution`, with the pixel's own value as the reference.

    Returns
    -------
    (H, W) float32
        The value itself where the neighbours determine no plane.

    Examples
    --------
    >>> z = np.float32(np.add.outer(np.arange(5), 3 * np.arange(6)))
    >>> one = np.ones_like(z)
    >>> bool(np.abs(local_planes(z, one, 99 * one, gaussian_kernel(1.0)) - z).max() < 1e-3)
    True
    """
    known = np.isfinite(values)
    z = np.where(known, values, np.float32(0))
    trust = np.where(known, confidence, np.float32(0))
    gate = np.where(known, step, np.float32(-1))
    s, su, sv, suu, suv, svv, sz, suz, svz = _plane_moments(z, trust, gate, kernel)
    # Cramer's rule; cofactors of the first column
    c0 = suu * svv - suv * suv
    c1 = su * svv - suv * sv
    c2 = su * suv - suu * sv
    determinant = s * c0 - su * c1 + sv * c2
    determined = determinant > 1e-4 * s * suu * svv
    safe = np.where(determined, determinant, 1.0)
    offset = np.where(determined, (sz * c0 - suz * c1 + svz * c2) / safe, 0.0)
    return (values + offset).astype(np.float32)


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def _plane_moments(values: Image, weight: Image, gate: Image, kernel: Image) -> Image:
    """Σ w times 1, u, v, uu, uv, vv, and Σ w (z − centre) times 1, u, v: (9, H, W)."""
    rows, cols = values.shape
    radius = kernel.shape[0] // 2
    out = np.zeros((9, rows, cols), dtype=np.float32)
    w = np.empty(cols, dtype=np.float32)
    wz = np.empty(cols, dtype=np.float32)
    for y in range(rows):
        for v in range(max(-radius, -y), min(radius, rows - 1 - y) + 1):
            for u in range(max(-radius, 1 - cols), min(radius, cols - 1) + 1):
                g = kernel[v + radius] * kernel[u + radius]
                here, there = slice(max(0, -u), min(cols, cols - u)), max(0, u)
                z, level = values[y + v, there:], values[y, here]
                _gated(z, level, gate[y, here], weight[y + v, there:], g, w)
                wz[:] = 0.0
                _add_offset(w, z, level, wz[: len(level)])
                for k, factor in enumerate((1, u, v, u * u, u * v, v * v)):
                    _add_scaled(w, np.float32(factor), out[k, y, here])
                for k, factor in enumerate((1, u, v)):
                    _add_scaled(wz, np.float32(factor), out[6 + k, y, here])
    return out


def guided(
    values: Image, guide: Image, valid: NDArray[np.bool_], radius: int, smoothness: float
) -> Image:
    """Guided filter over valid pixels only.

    Parameters
    ----------
    values, guide : (H, W) float32
        Finite.
    valid : (H, W) bool
        Which of them count.
    radius : int
        Half the window, px.
    smoothness : float
        ε, in squared units of the guide.

    Returns
    -------
    (H, W) float32
        Meaningful where valid.

    References
    ----------
    K. He, J. Sun, X. Tang, 2013, doi:10.1109/TPAMI.2012.213.
    """
    weight = valid.astype(np.float32)
    size = (2 * radius + 1, 2 * radius + 1)
    count = np.maximum(cv2.blur(weight, size, borderType=cv2.BORDER_CONSTANT), np.float32(1e-6))

    def mean(image: Image) -> Image:
        return cv2.blur(image * weight, size, borderType=cv2.BORDER_CONSTANT) / count

    mean_i, mean_z = mean(guide), mean(values)
    covariance = mean(guide * values) - mean_i * mean_z
    variance = (mean(guide * guide) - mean_i * mean_i).astype(np.float32)
    slope: Image = covariance / (variance + np.float32(smoothness))
    return mean(slope) * guide + mean(mean_z - slope * mean_i)


def total_variation(
    values: Image, valid: NDArray[np.bool_], weight: Image, iterations: int
) -> Image:
    r"""Total-variation denoising by projected gradients on the dual, with free edges at holes.

    .. math:: \min_u \tfrac12 \|(u - z) / \sqrt{λ}\|^2 + \operatorname{TV}(u)

    Parameters
    ----------
    values : (H, W) float32
        z; anything where not valid.
    valid : (H, W) bool
        Differences across an invalid pixel do not count.
    weight : (H, W) float32
        λ ≥ 0 of each pixel, in the unit of the values.
    iterations : int
        ≥ 1.

    Returns
    -------
    (H, W) float32
        0 where not valid.

    References
    ----------
    A. Chambolle, 2004, doi:10.1023/B:JMIV.0000011325.36760.1e; A. Beck, M. Teboulle, IEEE Trans.
    Image Process. 18(11), 2009, doi:10.1109/TIP.2009.2028250 (the accelerated projection).
    """
    z = np.where(valid, values, np.float32(0))
    largest = np.float32(max(float(weight[valid].max()), 1e-12))
    right = np.zeros_like(z)
    down = np.zeros_like(z)
    right[:, :-1] = valid[:, :-1] & valid[:, 1:]
    down[:-1] = valid[:-1] & valid[1:]
    px, py = np.zeros_like(z), np.zeros_like(z)
    qx, qy, momentum = px, py, 1.0
    for _ in range(iterations):
        u = z + weight * _divergence(qx, qy)
        # 8 bounds the norm of the divergence squared
        step = np.float32(1.0 / 8.0) / largest
        nx = qx + step * right * np.diff(u, axis=1, append=u[:, -1:])
        ny = qy + step * down * np.diff(u, axis=0, append=u[-1:])
        length = np.maximum(1.0, np.sqrt(nx * nx + ny * ny))
        nx, ny = nx / length, ny / length
        after = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
        ahead = np.float32((momentum - 1.0) / after)
        qx, qy = nx + ahead * (nx - px), ny + ahead * (ny - py)
        px, py, momentum = nx, ny, after
    return z + weight * _divergence(px, py)


def _divergence(px: Image, py: Image) -> Image:
    """Minus the adjoint of forward differences."""
    zero_column, zero_row = np.zeros_like(px[:, :1]), np.zeros_like(py[:1])
    return np.diff(px, axis=1, prepend=zero_column) + np.diff(py, axis=0, prepend=zero_row)


def diffused(values: Image, edge: float, iterations: int, step: float) -> Image:
    """Explicit steps of Perona and Malik's diffusion; nothing flows into or out of NaN.

    Parameters
    ----------
    values : (H, W) float32
        NaN = hole.
    edge : float
        κ > 0, in the unit of the values.
    iterations : int
        Number of steps.
    step : float
        Time step, ≤ 1/4 for stability.

    Returns
    -------
    (H, W) float32

    References
    ----------
    P. Perona, J. Malik, 1990, doi:10.1109/34.56205.
    """
    z = values.copy()
    inverse = np.float32(1.0 / edge**2)
    for _ in range(iterations):
        flow = np.zeros_like(z)
        for axis in (0, 1):
            gradient = np.nan_to_num(np.diff(z, axis=axis))
            flux = gradient * np.exp(-gradient * gradient * inverse)
            flow += np.diff(flux, axis=axis, prepend=0, append=0)
        z += np.float32(step) * flow
    return z
