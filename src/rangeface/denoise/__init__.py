"""image → image, and frames → one image.

Every entry of `METHODS` has the form ``(image, *, keyword parameters) → RangeImage``, and of
`COMBINE` ``(frames, *, poses=None, …) → RangeImage``. No invalid pixel ever changes a valid
one; what a method fills in, it marks in `filled`; σ follows where it is known.
"""

from __future__ import annotations

from rangeface.denoise import combine
from rangeface.denoise._anisotropic_diffusion import anisotropic_diffusion
from rangeface.denoise._auto import auto
from rangeface.denoise._bilateral import bilateral
from rangeface.denoise._dtcwt import dtcwt
from rangeface.denoise._dwt import dwt
from rangeface.denoise._flying_pixels import flying_pixels
from rangeface.denoise._guided import guided
from rangeface.denoise._median import median
from rangeface.denoise._moving_least_squares import moving_least_squares
from rangeface.denoise._noise import sigma_map
from rangeface.denoise._non_local_means import non_local_means
from rangeface.denoise._none import none
from rangeface.denoise._normalized_convolution import normalized_convolution
from rangeface.denoise._total_variation import total_variation
from rangeface.denoise.combine import COMBINE

METHODS = {
    "none": none,
    "auto": auto,
    "median": median,
    "normalized_convolution": normalized_convolution,
    "moving_least_squares": moving_least_squares,
    "dwt": dwt,
    "dtcwt": dtcwt,
    "bilateral": bilateral,
    "guided": guided,
    "non_local_means": non_local_means,
    "total_variation": total_variation,
    "anisotropic_diffusion": anisotropic_diffusion,
    "flying_pixels": flying_pixels,
}

__all__ = [
    "COMBINE",
    "METHODS",
    "anisotropic_diffusion",
    "auto",
    "bilateral",
    "combine",
    "dtcwt",
    "dwt",
    "flying_pixels",
    "guided",
    "median",
    "moving_least_squares",
    "non_local_means",
    "none",
    "normalized_convolution",
    "sigma_map",
    "total_variation",
]
