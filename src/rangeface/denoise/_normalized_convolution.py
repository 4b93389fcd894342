from __future__ import annotations

import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._confidence import Confidence, confidence_of
from rangeface.denoise._noise import sigma_map
from rangeface.numerics import holes, smoothing
from rangeface.types import Float32, RangeImage


def normalized_convolution(
    image: RangeImage,
    *,
    sigma_px: float = 1.0,
    confidence: Confidence = "amplitude_squared",
    max_step_mm: float | None = 20.0,
    fill: bool = True,
    min_support: float = 0.5,
) -> RangeImage:
    r"""Gaussian smoothing in which every pixel weighs as much as it is trusted (eq. 3.6).

    .. math:: I' = \frac{g * (C \cdot I)}{g * C}

    Parameters
    ----------
    image : RangeImage
        Any image.
    sigma_px : float
        Standard deviation of the Gaussian g, px, > 0.
    confidence : str
        C: "amplitude_squared" (= 1/σ² up to a factor), "amplitude", "inverse_amplitude" (the
        paper's words) or "uniform". 1/σ stands in for a missing amplitude; without either, C
        is uniform.
    max_step_mm : float or None
        A neighbour whose depth differs by more (beyond its noise, 3√2 σ where σ is known)
        belongs to another surface and is left out; None smooths across everything, twice as
        fast.
    fill : bool
        Fill holes of which the kernel sees enough, and mark them in `filled`.
    min_support : float
        The part of the kernel, 0 … 1, that must lie on valid pixels for a hole to be filled.
        Above 1/2 a silhouette does not grow.

    Returns
    -------
    RangeImage
        σ is propagated as if the pixels were independent; what was smoothed before is not.

    Raises
    ------
    ParameterError
        A width or step is not positive, the support is outside 0 … 1, or the confidence is
        unknown.

    Notes
    -----
    The paper takes the *inverse* amplitude as confidence; since σ ∝ 1/A that trusts the noisy
    pixels most, so A² is the default here.

    References
    ----------
    H. Knutsson, C.-F. Westin, CVPR 1993, doi:10.1109/CVPR.1993.341081.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> depth = np.full((5, 5), 400.0)
    >>> depth[2, 2] = np.nan
    >>> out = normalized_convolution(RangeImage(depth, Orthographic(2.0, 2, 2, 5, 5)))
    >>> float(out.depth[2, 2]), bool(out.filled[2, 2])
    (400.0, True)
    """
    _check.positive("sigma_px", sigma_px)
    _check.fraction("min_support", min_support)
    if max_step_mm is not None:
        _check.positive("max_step_mm", max_step_mm)
    weights = confidence_of(image, confidence)
    if not weights.any():
        return image
    kernel = smoothing.gaussian_kernel(sigma_px)
    if max_step_mm is None:
        depth, spread = _across_steps(image, weights, kernel)
    else:
        depth, spread = _within_steps(image, weights, kernel, max_step_mm, fill)
    # a pixel without confidence keeps its measured depth unless neighbours speak for it
    kept = image.mask & np.isfinite(depth)
    if fill and not image.mask.all():
        support = smoothing.blurred(image.mask.astype(np.float32), kernel)
        filled = ~image.mask & (support >= min_support) & np.isfinite(depth)
    else:
        filled = np.zeros(image.shape, dtype=bool)
    new = kept | filled
    sigma = image.sigma
    if sigma is not None and spread is not None:
        sigma = np.where(new, np.sqrt(spread), sigma)
    before = filled if image.filled is None else image.filled | filled
    return image.with_depth(np.where(new, depth, image.depth), sigma=sigma, filled=before)


def _variance(image: RangeImage) -> Float32 | None:
    return None if image.sigma is None else image.sigma * image.sigma


def _across_steps(
    image: RangeImage, weights: Float32, kernel: Float32
) -> tuple[Float32, Float32 | None]:
    # around the middle the float32 sums lose nothing, however far away the scene is
    level = np.float32(np.nanmean(image.depth))
    depth, spread, _ = smoothing.normalized_convolution(
        image.depth - level, weights, _variance(image), kernel
    )
    return depth + level, spread


def _within_steps(
    image: RangeImage, weights: Float32, kernel: Float32, max_step_mm: float, fill: bool
) -> tuple[Float32, Float32 | None]:
    step = np.full(image.shape, max_step_mm, dtype=np.float32)
    if image.sigma is not None:
        step += np.float32(3.0 * np.sqrt(2.0)) * sigma_map(image)
    reference = image.depth
    if fill and not image.mask.all():
        reference = holes.nearest_valid(image.depth, image.mask)
    depth, spread, _ = smoothing.gated_convolution(
        image.depth, weights, _variance(image), reference, step, kernel
    )
    return depth, spread
