"""What stands in for a pixel that was not measured."""

from __future__ import annotations

from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError

Float32: TypeAlias = NDArray[np.float32]
Mask: TypeAlias = NDArray[np.bool_]


def fill_mean(channels: ArrayLike, *, axis: int | tuple[int, ...] = (0, 1)) -> Float32:
    """Replace NaN by the mean of the valid values: the value that pulls to no side.

    Parameters
    ----------
    channels : array_like
        Values, NaN where invalid.
    axis : int or tuple of int
        Axes over which a mean is taken; by default rows and columns, so that each channel
        of an (H, W, k) array has its own.

    Returns
    -------
    float32 array of the same shape
        Finite everywhere.

    Raises
    ------
    DegenerateError
        A channel has no valid value.

    Examples
    --------
    >>> fill_mean([[1.0, np.nan], [2.0, 3.0]])
    array([[1., 2.],
           [2., 3.]], dtype=float32)
    """
    values = np.asarray(channels, dtype=np.float32)
    valid = np.isfinite(values)
    if valid.all():
        return values.copy()
    count = valid.sum(axis=axis, keepdims=True)
    if (count == 0).any():
        raise DegenerateError("image: no valid pixel carries this feature; denoise or fill first")
    total = np.where(valid, values, 0.0).sum(axis=axis, keepdims=True, dtype=np.float64)
    return np.where(valid, values, total / count).astype(np.float32)


def nearest_valid(values: Float32, valid: Mask) -> Float32:
    """Give every pixel the value of the nearest valid pixel.

    Parameters
    ----------
    values : (H, W) float32
    valid : (H, W) bool
        At least one pixel.

    Returns
    -------
    (H, W) float32

    Examples
    --------
    >>> nearest_valid(np.float32([[1, 0, 0, 5]]), np.array([[True, False, False, True]]))
    array([[1., 1., 5., 5.]], dtype=float32)
    """
    _, label = cv2.distanceTransformWithLabels(
        (~valid).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_label = np.zeros(int(label.max()) + 1, dtype=np.float32)
    of_label[label[valid]] = values[valid]
    return of_label[label]


def extended(values: Float32, valid: Mask) -> Float32:
    """Continue the valid pixels smoothly into the holes (pull-push).

    Means over ever larger blocks are pulled from the valid pixels, then pushed back into what
    is still empty: an image without a step at the edge of a hole, in linear time.

    Parameters
    ----------
    values : (H, W) float32
        Anything, NaN too, where not valid.
    valid : (H, W) bool
        At least one pixel.

    Returns
    -------
    (H, W) float32
        Finite; the valid pixels as they are.

    References
    ----------
    S. J. Gortler et al., SIGGRAPH 1996, doi:10.1145/237170.237200 (pull-push).

    Examples
    --------
    >>> extended(np.float32([[1, np.nan, 1, 1]]), np.array([[True, False, True, True]]))
    array([[1., 1., 1., 1.]], dtype=float32)
    """
    if valid.all():
        return values
    rows, cols = values.shape
    half = (cols + 1) // 2, (rows + 1) // 2
    weight = valid.astype(np.float32)
    coarse_weight = _halved(weight)
    coarse = _halved(np.where(valid, values, np.float32(0)))
    known = coarse_weight > 0
    coarse = np.divide(coarse, coarse_weight, out=coarse, where=known)
    pulled = extended(coarse, known)
    pushed = cv2.resize(pulled, (2 * half[0], 2 * half[1]), interpolation=cv2.INTER_LINEAR)
    return np.where(valid, values, pushed[:rows, :cols])


def _halved(image: Float32) -> Float32:
    """Mean over 2 × 2 blocks; an odd edge counts as empty."""
    rows, cols = image.shape
    even = cv2.copyMakeBorder(image, 0, rows % 2, 0, cols % 2, cv2.BORDER_CONSTANT, value=0)
    return cv2.resize(even, (even.shape[1] // 2, even.shape[0] // 2), interpolation=cv2.INTER_AREA)
