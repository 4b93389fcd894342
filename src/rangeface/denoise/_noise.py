"""What is known of an image's noise: the sensor's word first, the image's own second."""

from __future__ import annotations

import numpy as np

from rangeface.numerics import noise
from rangeface.types import Float32, RangeImage


def sigma_map(image: RangeImage) -> Float32:
    """Standard deviation of every pixel, mm, (H, W): σ of the sensor, else one estimate.

    Holes, and gaps in a sensor's σ (not finite, negative), take the median of the rest. An
    image too small or too full of holes to be judged counts as free of noise.
    """
    estimate = np.full(image.shape, np.nan, np.float32) if image.sigma is None else image.sigma
    known = image.mask & np.isfinite(estimate) & (estimate >= 0)
    if known.all():
        return estimate
    if known.any():
        middle = np.median(estimate[known])
    else:
        middle = np.float32(np.nan_to_num(noise.estimate_sigma(image.depth)))
    return np.where(known, estimate, middle).astype(np.float32)
