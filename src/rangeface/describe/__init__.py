"""frontal image → feature image or vector.

A frontal image is a `RangeImage` with an orthographic camera in the face frame. Every method
returns finite float32; what it does about holes stands in its docstring.
"""

from __future__ import annotations

from typing import NamedTuple

from rangeface.describe._depth import depth
from rangeface.describe._depth_levels import depth_levels
from rangeface.describe._lbp import lbp
from rangeface.describe._n3 import n3
from rangeface.describe._normals import normals
from rangeface.describe._tdlbp import tdlbp


class Output(NamedTuple):
    """What a method returns with its defaults: "image", "channels" or "vector", and its range."""

    kind: str
    low: float
    high: float
    needs_amplitude: bool = False


_INF = float("inf")

METHODS = {
    "depth": depth,
    "depth_levels": depth_levels,
    "normals": normals,
    "n3": n3,
    "lbp": lbp,
    "tdlbp": tdlbp,
}
"""Every method by name."""

OUTPUTS = {
    "depth": Output("image", -_INF, _INF),
    "depth_levels": Output("image", 0.0, 255.0),
    "normals": Output("channels", -1.0, 1.0),
    "n3": Output("image", 0.0, 1.0),
    "lbp": Output("image", 0.0, 9.0),
    "tdlbp": Output("channels", 0.0, 255.0),
}
"""What each method returns: (H, W), (H, W, k) or (n,), between which bounds."""

__all__ = [
    "METHODS",
    "OUTPUTS",
    "Output",
    "depth",
    "depth_levels",
    "lbp",
    "n3",
    "normals",
    "tdlbp",
]
