"""What every descriptor asks of its image."""

from __future__ import annotations

from rangeface.errors import DegenerateError, ParameterError
from rangeface.types import Orthographic, RangeImage


def pitch_of(image: RangeImage) -> float:
    """Edge of a pixel, mm, of a frontal image.

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
    return image.camera.pitch_mm
