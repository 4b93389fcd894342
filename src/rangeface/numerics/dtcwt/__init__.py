"""The dual-tree complex wavelet transform, in one and two dimensions."""

from __future__ import annotations

from rangeface.numerics.dtcwt.transform import (
    Pyramid,
    forward_1d,
    forward_2d,
    inverse_1d,
    inverse_2d,
)

__all__ = ["Pyramid", "forward_1d", "forward_2d", "inverse_1d", "inverse_2d"]
