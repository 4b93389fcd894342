from __future__ import annotations

import numpy as np

from rangeface.denoise._dtcwt import dtcwt
from rangeface.denoise._noise import sigma_map
from rangeface.denoise._normalized_convolution import normalized_convolution
from rangeface.types import RangeImage, revision

# wider structure is averaged over enough pixels to survive any noise worth denoising
_COARSEST_MM = 10.0
# noise far below the relief that tells faces apart is left alone
_NEGLIGIBLE_MM = 0.05
# with fewer neighbours than holes, sub-bands would judge what was filled in
_SPARSE = 0.4


@revision(2)
def auto(image: RangeImage) -> RangeImage:
    """Choose method and strength from the noise, the valid fraction and the resolution.

    * σ comes from the sensor, pixel by pixel, or else from the image. Where its median is under
      0.05 mm nothing is done.
    * Where less than 0.4 of the valid pixels' bounding box is valid: `normalized_convolution`
      without filling, as wide as one pixel.
    * Otherwise `dtcwt` with Wiener shrinkage, whose strength is σ itself, down to structures
      of about 10 mm: 2 to 6 levels by the footprint of a pixel.

    Parameters
    ----------
    image : RangeImage
        Any image.

    Returns
    -------
    RangeImage
        Holes stay holes.

    Notes
    -----
    The strength follows the noise, so that a good image is hardly touched: what a denoiser
    with one strength for all takes from good images is more than what it gives to bad ones.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    >>> camera = Orthographic(2.8, 24.5, 39.5, 50, 80)
    >>> bool(np.std(auto(RangeImage(500.0 + noise, camera)).depth) < 0.5)
    True
    >>> clean = RangeImage(np.full((80, 50), 500.0), camera)
    >>> auto(clean) is clean
    True
    """
    if not image.mask.any():
        return image
    sigma_mm = float(np.median(sigma_map(image)[image.mask]))
    if sigma_mm < _NEGLIGIBLE_MM:
        return image
    rows, cols = np.nonzero(image.mask)
    box = (np.ptp(rows) + 1) * (np.ptp(cols) + 1)
    if len(rows) < _SPARSE * box:
        return normalized_convolution(image, sigma_px=1.0, fill=False)
    pixel_mm = image.camera.pixel_mm(float(np.nanmean(image.depth)))
    levels = int(np.clip(np.round(np.log2(_COARSEST_MM / pixel_mm)), 2, 6))
    return dtcwt(image, shrinkage="wiener", levels=levels)
