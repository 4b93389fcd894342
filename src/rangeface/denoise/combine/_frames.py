"""What all combinations of frames share: one look at every frame, in order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from rangeface.errors import ParameterError
from rangeface.types import Float64, Mask, RangeImage


def alike(frames: Iterable[RangeImage]) -> Iterator[RangeImage]:
    """Pass frames on, one by one; refuse none at all, and a frame of another camera."""
    first = None
    for number, frame in enumerate(frames):
        first = frame if first is None else first
        if frame.camera != first.camera:
            raise ParameterError(f"frames: frame {number} has another camera than frame 0")
        yield frame
    if first is None:
        raise ParameterError("frames: there is none")


def measured(frame: RangeImage) -> Mask:
    """Pixels that the sensor measured: valid and not filled in."""
    return frame.mask if frame.filled is None else frame.mask & ~frame.filled


def divide(numerator: Float64, denominator: Float64) -> Float64:
    """Quotient of two planes, NaN where the denominator is 0."""
    out: Float64 = np.full(denominator.shape, np.nan)
    return np.divide(numerator, denominator, out=out, where=denominator > 0)
