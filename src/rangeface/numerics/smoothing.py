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
    values: Image, confidence: Image, variance: Image, sigma_px: float
) -> tuple[Image, Image, Image]:
    r"""Gaussian mean of an image, each pixel weighted by its confidence.

    .. math:: I' = \frac{g * (C I)}{g * C}, \qquad
              \operatorname{var} I' = \frac{g^2 * (C^2 \operatorname{var} I)}{(g * C)^2}

    Parameters
    ----------
    values : (H, W) float32
        Finite wherever the confidence is not 0.
    confidence : (H, W) float32
        C ≥ 0; 0 = nothing known.
    variance : (H, W) float32
        Of the values, which are taken as independent.
    sigma_px : float
        Standard deviation of g, px.

    Returns
    -------
    mean, variance : (H, W) float32
        NaN where no confidence is in reach.
    support : (H, W) float32
        The part of g, 0 … 1, that lies on pixels with confidence; outside the image is none.

    References
    ----------
    H. Knutsson, C.-F. Westin, CVPR 1993, doi:10.1109/CVPR.1993.341081.

    Examples
    --------
    >>> z, c = np.float32([[1, 9, 3]]), np.float32([[1, 0, 1]])
    >>> mean, _, _ = normalized_convolution(z, c, c, 1.0)
    >>> float(mean[0, 1])
    2.0
    """
    g = gaussian_kernel(sigma_px)
    known = confidence > 0
    weighted = np.where(known, confidence * values, np.float32(0))
    weight = _blur(confidence, g)
    reached = weight > 0
    safe: Image = np.where(reached, weight, np.float32(np.nan))
    spread = np.where(known, confidence**2 * variance, np.float32(0))
    support = _blur(known.astype(np.float32), g)
    return _blur(weighted, g) / safe, _blur(spread, g * g) / safe**2, support


def _blur(image: Image, kernel: Image) -> Image:
    return cv2.sepFilter2D(image, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_CONSTANT)


@njit(cache=True, nogil=True, fastmath=_FASTMATH)
def gated_convolution(
    values: Image,
    confidence: Image,
    variance: Image,
    reference: Image,
    step: Image,
    kernel: Image,
) -> tuple[Image, Image, Image]:
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
        Separable kernel g, Σ g = 1.

    Returns
    -------
    mean, variance, support : (H, W) float32
        As in `normalized_convolution`, the support counting pixels inside the gate.

    Examples
    --------
    >>> z = np.float32([[400, 402, 900]])
    >>> one, step = np.ones_like(z), np.full_like(z, 20)
    >>> mean, _, _ = gated_convolution(z, one, one, z, step, gaussian_kernel(9.0))
    >>> mean.round(1)
    array([[401., 401., 900.]], dtype=float32)
    """
    rows, cols = values.shape
    radius = kernel.shape[0] // 2
    mean = np.empty((rows, cols), dtype=np.float32)
    spread = np.empty((rows, cols), dtype=np.float32)
    support = np.zeros((rows, cols), dtype=np.float32)
    weight = np.empty(cols, dtype=np.float32)
    total = np.empty(cols, dtype=np.float32)
    noise = np.empty(cols, dtype=np.float32)
    for y in range(rows):
        weight[:] = 0.0
        total[:] = 0.0
        noise[:] = 0.0
        centre, gate, part = reference[y], step[y], support[y]
        for dy in range(max(-radius, -y), min(radius, rows - 1 - y) + 1):
            line, trust, var = values[y + dy], confidence[y + dy], variance[y + dy]
            for dx in range(-radius, radius + 1):
                g = kernel[dy + radius] * kernel[dx + radius]
                for x in range(max(0, -dx), min(cols, cols - dx)):
                    # offsets from the reference keep float32 exact at large depths
                    offset = line[x + dx] - centre[x]
                    near = abs(offset) <= gate[x] and trust[x + dx] > 0.0
                    w = g * trust[x + dx] if near else np.float32(0.0)
                    weight[x] += w
                    total[x] += w * offset if near else np.float32(0.0)
                    noise[x] += w * w * var[x + dx] if near else np.float32(0.0)
                    part[x] += g if near else np.float32(0.0)
        for x in range(cols):
            if weight[x] > 0.0:
                mean[y, x] = centre[x] + total[x] / weight[x]
                spread[y, x] = noise[x] / (weight[x] * weight[x])
            else:
                mean[y, x] = np.nan
                spread[y, x] = np.nan
    return mean, spread, support


def nearest_valid(values: Image, valid: NDArray[np.bool_]) -> Image:
    """Give every pixel the value of the nearest valid pixel.

    Parameters
    ----------
    values : (H, W) float32
    valid : (H, W) bool
        At least one pixel.

    Returns
    -------
    (H, W) float32

    Examples
    --------
    >>> nearest_valid(np.float32([[1, 0, 0, 5]]), np.array([[True, False, False, True]]))
    array([[1., 1., 5., 5.]], dtype=float32)
    """
    _, label = cv2.distanceTransformWithLabels(
        (~valid).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_label = np.zeros(int(label.max()) + 1, dtype=np.float32)
    of_label[label[valid]] = values[valid]
    return of_label[label]
