"""frontal image → feature image or vector.

A frontal image is a `RangeImage` with an orthographic camera in the face frame. Every method
returns finite float32; what it does about holes stands in its docstring.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rangeface.describe._albedo import albedo
from rangeface.describe._albedo_lbp import albedo_lbp
from rangeface.describe._block_covariance import block_covariance
from rangeface.describe._curvature import curvature
from rangeface.describe._curvature_sigma import curvature_sigma
from rangeface.describe._depth import depth
from rangeface.describe._depth_levels import depth_levels
from rangeface.describe._dtcwt import dtcwt
from rangeface.describe._gabor import gabor
from rangeface.describe._hog import hog
from rangeface.describe._horizontal_profile import (
    horizontal_curve,
    horizontal_profile,
    profile_height,
)
from rangeface.describe._hso import hso
from rangeface.describe._lbp import lbp
from rangeface.describe._lbp_histogram import lbp_histogram
from rangeface.describe._lhg import lhg
from rangeface.describe._local_normal_patterns import local_normal_patterns
from rangeface.describe._n3 import n3
from rangeface.describe._normal_angle import normal_angle
from rangeface.describe._normals import normals
from rangeface.describe._normals_covariance import normals_covariance
from rangeface.describe._profiles import profiles
from rangeface.describe._radial_curves import radial_curves
from rangeface.describe._surface import surface
from rangeface.describe._tdlbp import tdlbp
from rangeface.describe._tdlbp_histogram import tdlbp_histogram
from rangeface.describe._vertical_profile import symmetry_line, vertical_curve, vertical_profile
from rangeface.types import Float32


class Output(NamedTuple):
    """What a method returns with its defaults.

    kind is "image" (H, W), "channels" (H, W, k), "vector" (n,) or "histogram" (n,).
    """

    kind: str
    low: float
    high: float
    needs_amplitude: bool = False


_INF = float("inf")

METHODS = {
    "depth": depth,
    "depth_levels": depth_levels,
    "surface": surface,
    "normals": normals,
    "n3": n3,
    "normal_angle": normal_angle,
    "curvature": curvature,
    "lbp": lbp,
    "lbp_histogram": lbp_histogram,
    "tdlbp": tdlbp,
    "tdlbp_histogram": tdlbp_histogram,
    "local_normal_patterns": local_normal_patterns,
    "hso": hso,
    "lhg": lhg,
    "vertical_profile": vertical_profile,
    "horizontal_profile": horizontal_profile,
    "profiles": profiles,
    "radial_curves": radial_curves,
    "dtcwt": dtcwt,
    "gabor": gabor,
    "hog": hog,
    "block_covariance": block_covariance,
    "albedo": albedo,
    "albedo_lbp": albedo_lbp,
}
"""Every method by name."""

OUTPUTS = {
    "depth": Output("image", -_INF, _INF),
    "depth_levels": Output("image", 0.0, 255.0),
    "surface": Output("channels", -_INF, _INF),
    "normals": Output("channels", -1.0, 1.0),
    "n3": Output("image", 0.0, 1.0),
    "normal_angle": Output("image", -_INF, _INF),
    "curvature": Output("image", -_INF, _INF),
    "lbp": Output("image", 0.0, 9.0),
    "lbp_histogram": Output("histogram", 0.0, 1.0),
    "tdlbp": Output("channels", 0.0, 255.0),
    "tdlbp_histogram": Output("histogram", 0.0, 1.0),
    "local_normal_patterns": Output("channels", 0.0, 58.0),
    "hso": Output("image", -_INF, _INF),
    "lhg": Output("image", -_INF, _INF),
    "vertical_profile": Output("vector", -_INF, _INF),
    "horizontal_profile": Output("vector", -_INF, _INF),
    "profiles": Output("vector", -_INF, _INF),
    "radial_curves": Output("vector", -_INF, _INF),
    "dtcwt": Output("vector", 0.0, _INF),
    "gabor": Output("channels", 0.0, _INF),
    "hog": Output("histogram", 0.0, 1.0),
    "block_covariance": Output("vector", -_INF, _INF),
    "albedo": Output("image", -1.3862944, 1.3862944, needs_amplitude=True),
    "albedo_lbp": Output("image", 0.0, 9.0, needs_amplitude=True),
}
"""What each method returns, and between which bounds."""

UNCERTAINTY: dict[str, Callable[..., Float32]] = {
    "normals": normals_covariance,
    "curvature": curvature_sigma,
}
"""How well a method's values are known, where the noise of the depth says it."""

__all__ = [
    "METHODS",
    "OUTPUTS",
    "UNCERTAINTY",
    "Output",
    "albedo",
    "albedo_lbp",
    "block_covariance",
    "curvature",
    "curvature_sigma",
    "depth",
    "depth_levels",
    "dtcwt",
    "gabor",
    "hog",
    "horizontal_curve",
    "horizontal_profile",
    "hso",
    "lbp",
    "lbp_histogram",
    "lhg",
    "local_normal_patterns",
    "n3",
    "normal_angle",
    "normals",
    "normals_covariance",
    "profile_height",
    "profiles",
    "radial_curves",
    "surface",
    "symmetry_line",
    "tdlbp",
    "tdlbp_histogram",
    "vertical_curve",
    "vertical_profile",
]
