"""One image or many: kernels work on (n, H, W) float32, callers may pass (…, H, W)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError


def as_batch(
    images: ArrayLike, *, at_least: int = 1
) -> tuple[NDArray[np.float32], tuple[int, ...]]:
    """Images (…, H, W) as a contiguous batch (n, H, W), and the leading shape to go back to.

    Parameters
    ----------
    images : (…, H, W) array_like
        Any unit; NaN marks invalid pixels.
    at_least : int
        Smallest number of rows and of columns that the caller's neighbourhood needs, px.

    Returns
    -------
    batch : (n, H, W) float32
    leading : tuple of int
        Shape before (H, W); empty for a single image.

    Raises
    ------
    ParameterError
        Fewer than two dimensions, or an image smaller than the neighbourhood.

    Examples
    --------
    >>> batch, leading = as_batch(np.zeros((4, 5)))
    >>> batch.shape, leading
    ((1, 4, 5), ())
    """
    array = np.ascontiguousarray(images, dtype=np.float32)
    if array.ndim < 2:
        raise ParameterError(f"images: expected (…, H, W), got shape {array.shape}")
    height, width = array.shape[-2:]
    if height < at_least or width < at_least:
        raise ParameterError(
            f"images: {height} × {width} px is smaller than the neighbourhood"
            f" ({at_least} × {at_least} px)"
        )
    return array.reshape(-1, height, width), array.shape[:-2]
