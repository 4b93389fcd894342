"""image → image, and frames → one image.

Every entry of `METHODS` has the form ``(image, *, keyword parameters) → RangeImage``, and of
`COMBINE` ``(frames, *, poses=None, …) → RangeImage``. No invalid pixel ever changes a valid
one; what a method fills in, it marks in `filled`; σ follows where it is known.
"""

from __future__ import annotations

from rangeface.denoise import combine
from rangeface.denoise._flying_pixels import flying_pixels
from rangeface.denoise._median import median
from rangeface.denoise._none import none
from rangeface.denoise._normalized_convolution import normalized_convolution
from rangeface.denoise.combine import COMBINE

METHODS = {
    "none": none,
    "median": median,
    "normalized_convolution": normalized_convolution,
    "flying_pixels": flying_pixels,
}

__all__ = [
    "COMBINE",
    "METHODS",
    "combine",
    "flying_pixels",
    "median",
    "none",
    "normalized_convolution",
]
