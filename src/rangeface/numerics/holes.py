"""What stands in for a pixel that was not measured."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import DegenerateError

Float32: TypeAlias = NDArray[np.float32]


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
