"""frames → one image.

Every entry of `COMBINE` has the form ``(frames, *, poses=None, …) → RangeImage``.
"""

from __future__ import annotations

from rangeface.denoise.combine._mean import mean
from rangeface.denoise.combine._phasor_mean import phasor_mean

COMBINE = {
    "mean": mean,
    "phasor_mean": phasor_mean,
}

__all__ = ["COMBINE", "mean", "phasor_mean"]
