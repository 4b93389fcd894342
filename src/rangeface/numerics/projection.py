"""How camera coordinates become pixel coordinates."""

from __future__ import annotations

from typing import NamedTuple


class Projection(NamedTuple):
    """u = sx·x/z + cx, v = sy·y/z + cy; without perspective the division by z falls away.

    Attributes
    ----------
    perspective : bool
        Pinhole (True) or parallel rays (False).
    sx, sy : float
        Focal lengths (px) or pixels per mm.
    cx, cy : float
        Pixel coordinates of the optical axis.
    """

    perspective: bool
    sx: float
    sy: float
    cx: float
    cy: float

    def pooled(self, factor: int) -> Projection:
        """The projection onto a grid whose pixels are blocks of factor × factor."""
        shift = 0.5 * (factor - 1)
        return Projection(
            self.perspective,
            self.sx / factor,
            self.sy / factor,
            (self.cx - shift) / factor,
            (self.cy - shift) / factor,
        )
