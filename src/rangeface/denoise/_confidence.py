"""How far each measured pixel is to be trusted."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from rangeface.errors import ParameterError
from rangeface.types import Float32, RangeImage

Confidence: TypeAlias = Literal["amplitude_squared", "amplitude", "inverse_amplitude", "uniform"]

_EXPONENTS = {"amplitude_squared": 2, "amplitude": 1, "inverse_amplitude": -1, "uniform": 0}


def confidence_of(image: RangeImage, confidence: str) -> Float32:
    """Confidence of each pixel, (H, W), 0 where it is invalid.

    Where the image has no amplitude, 1/σ stands in for it (σ ∝ 1/A in a time-of-flight
    camera); where it has neither, every measured pixel counts alike.
    """
    if confidence not in _EXPONENTS:
        raise ParameterError(f"confidence: {confidence!r} is none of {', '.join(_EXPONENTS)}")
    strength = amplitude_of(image)
    usable = image.mask & (strength > 0)
    out = np.zeros(image.shape, dtype=np.float32)
    out[usable] = strength[usable] ** _EXPONENTS[confidence]
    return out


def amplitude_of(image: RangeImage) -> Float32:
    """Amplitude, or what is proportional to it: 1/σ, or ones where σ is unknown too."""
    if image.amplitude is not None:
        return np.nan_to_num(image.amplitude, nan=0.0, posinf=0.0, neginf=0.0)
    if image.sigma is not None:
        known = np.isfinite(image.sigma) & (image.sigma > 0)
        return np.divide(1.0, image.sigma, out=np.zeros_like(image.sigma), where=known)
    return np.ones(image.shape, dtype=np.float32)
