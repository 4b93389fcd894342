"""What every descriptor asks of its image."""

from __future__ import annotations

import numpy as np

from rangeface.errors import DegenerateError, ParameterError
from rangeface.types import Float32, Orthographic, RangeImage


def camera_of(image: RangeImage) -> Orthographic:
    """The camera of a frontal image.

    Raises
    ------
    ParameterError
        The image is not frontal: its camera is not orthographic.
    DegenerateError
        The image has no valid pixel.
    """
    if not isinstance(image.camera, Orthographic):
        raise ParameterError(
            "image: a feature needs a frontal image (orthographic, face frame); register it first"
        )
    if not image.mask.any():
        raise DegenerateError("image: no valid pixels")
    return image.camera


def pitch_of(image: RangeImage) -> float:
    """Edge of a pixel, mm, of a frontal image; raises as `camera_of`."""
    return camera_of(image).pitch_mm


def sigma_of(image: RangeImage, sigma_mm: float | None) -> Float32:
    """Standard deviation of the depth, (H, W) mm: as given, or else as the image knows it.

    Raises
    ------
    ParameterError
        Neither is known, or the given one is not positive.
    """
    if sigma_mm is not None:
        if not (np.isfinite(sigma_mm) and sigma_mm > 0):
            raise ParameterError(f"sigma_mm: must be > 0, got {sigma_mm}")
        return np.full(image.shape, sigma_mm, np.float32)
    if image.sigma is None:
        raise ParameterError("sigma_mm: the image does not know its noise; give it in mm")
    return image.sigma


def amplitude_of(image: RangeImage) -> Float32:
    """The amplitude of a frontal image, (H, W) counts, NaN where it or the depth is invalid.

    Raises
    ------
    ParameterError
        The image is not frontal or has no amplitude.
    DegenerateError
        No pixel has both a depth and an amplitude > 0.
    """
    camera_of(image)
    if image.amplitude is None:
        raise ParameterError("image: an infrared feature needs the amplitude, which it lacks")
    known = image.mask & (np.nan_to_num(image.amplitude) > 0)
    if not known.any():
        raise DegenerateError("image: no pixel has both a depth and an amplitude > 0")
    return np.where(known, image.amplitude, np.nan).astype(np.float32)
