"""frames → one image.

Every entry of `COMBINE` has the form ``(frames, *, poses=None, …) → RangeImage``. Frames are
read once, in order, and not kept: memory does not grow with their number.
"""

from __future__ import annotations

from rangeface.denoise.combine._mean import mean
from rangeface.denoise.combine._motion_compensated_mean import motion_compensated_mean
from rangeface.denoise.combine._phasor_mean import phasor_mean
from rangeface.denoise.combine._recursive import recursive
from rangeface.denoise.combine._space_time_convolution import space_time_convolution

COMBINE = {
    "mean": mean,
    "phasor_mean": phasor_mean,
    "recursive": recursive,
    "space_time_convolution": space_time_convolution,
    "motion_compensated_mean": motion_compensated_mean,
}

# which of them need the pose of every frame
NEEDS_POSES = frozenset({"motion_compensated_mean"})

__all__ = [
    "COMBINE",
    "NEEDS_POSES",
    "mean",
    "motion_compensated_mean",
    "phasor_mean",
    "recursive",
    "space_time_convolution",
]
