"""Depth in the grey levels of the paper."""

from __future__ import annotations

import numpy as np

from rangeface.describe._frontal import pitch_of
from rangeface.errors import ParameterError
from rangeface.types import Float32, RangeImage

LEVELS_PER_MM = 255.0 / 140.0
"""The paper's display: 255 at the nose tip, 0 at 14 cm behind it."""


def depth_levels(image: RangeImage, *, levels_per_mm: float = LEVELS_PER_MM) -> Float32:
    r"""Depth as the paper's grey image: 255 at the nose tip, darker behind it.

    .. math:: g = \mathrm{clip}(\mathrm{round}(255 - s z), 0, 255)

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    levels_per_mm : float
        Slope s, grey levels per mm, > 0; the default is 255/140 ≈ 1.82.

    Returns
    -------
    (H, W) float32
        Whole numbers 0 … 255. A hole is background: 0.

    Raises
    ------
    ParameterError
        The image is not frontal, or the slope is not positive.
    DegenerateError
        The image has no valid pixel.

    Notes
    -----
    The slope follows from the PSNRs of the paper's Table 7, which are those of noise of 5, 3,
    2 and 1 grey levels, and from its crop sphere of 14 cm.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> depth_levels(RangeImage([[0.0, float("nan"), 70.0]], Orthographic(2.0, 0, 0, 3, 1)))
    array([[255.,   0., 128.]], dtype=float32)
    """
    pitch_of(image)
    if not (np.isfinite(levels_per_mm) and levels_per_mm > 0):
        raise ParameterError(f"levels_per_mm: must be > 0, got {levels_per_mm}")
    grey = np.clip(np.rint(255.0 - np.float32(levels_per_mm) * image.depth), 0.0, 255.0)
    return np.where(image.mask, grey, 0.0).astype(np.float32)
