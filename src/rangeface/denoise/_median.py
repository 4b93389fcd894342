from __future__ import annotations

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from rangeface.errors import ParameterError
from rangeface.types import RangeImage


def median(image: RangeImage, *, size_px: int = 3) -> RangeImage:
    """Median of the valid pixels in a square window.

    Parameters
    ----------
    image : RangeImage
        Any image.
    size_px : int
        Edge of the window, 3 or 5 px.

    Returns
    -------
    RangeImage
        Holes stay holes. σ is scaled by √(π / 2n) for n valid pixels in the window: the
        asymptotic law for Gaussian noise, never less than the pixel's own would allow.

    Raises
    ------
    ParameterError
        The size is neither 3 nor 5.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> depth = np.full((3, 3), 400.0)
    >>> depth[1, 1], depth[0, 0] = 900.0, np.nan
    >>> median(RangeImage(depth, Orthographic(2.0, 1, 1, 3, 3))).depth
    array([[ nan, 400., 400.],
           [400., 400., 400.],
           [400., 400., 400.]], dtype=float32)
    """
    if size_px not in (3, 5):
        raise ParameterError(f"size_px must be 3 or 5, got {size_px}")
    radius = size_px // 2
    padded = np.pad(image.depth, radius, constant_values=np.nan)
    valid = np.isfinite(padded).astype(np.float32)
    count = cv2.boxFilter(valid, -1, (size_px, size_px), normalize=False)[
        radius:-radius, radius:-radius
    ]
    whole = count > size_px**2 - 0.5
    depth = np.where(whole, cv2.medianBlur(np.nan_to_num(image.depth), size_px), image.depth)
    partial = image.mask & ~whole
    windows = sliding_window_view(padded, (size_px, size_px))[partial]
    if len(windows):
        depth[partial] = np.nanmedian(windows.reshape(len(windows), -1), axis=1)
    sigma = image.sigma
    if sigma is not None:
        sigma = sigma * np.sqrt(np.minimum(1.0, np.pi / (2.0 * np.maximum(count, 1.0))))
    return image.with_depth(depth, sigma=sigma)
