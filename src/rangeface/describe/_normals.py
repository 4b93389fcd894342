"""Surface normals and their embeddings."""

from __future__ import annotations

from collections.abc import Callable

from rangeface.describe._frontal import pitch_of
from rangeface.errors import ParameterError
from rangeface.numerics import holes, sphere
from rangeface.numerics import normals as estimate
from rangeface.types import Float32, RangeImage

COMPONENTS: dict[str, Callable[[Float32], Float32]] = {
    "xyz": lambda N: N,
    "xy": lambda N: N[..., :2],
    "polar": sphere.polar_stereographic,
    "stereographic": sphere.stereographic,
    "lambert": sphere.lambert,
    "log": sphere.log_map,
}
"""How the sphere is flattened: name → map of (…, 3) to (…, k)."""

METHODS = ("difference", "plane", "quadric")
"""How the slopes are found."""


def normals(
    image: RangeImage, *, components: str = "xyz", method: str = "plane", radius_px: float = 2.0
) -> Float32:
    r"""Unit normals of the face: the Gaussian map, or a flat picture of it.

    Parameters
    ----------
    image : RangeImage
        Frontal image; its `sigma`, where known, weights the fit by 1/σ².
    components : {"xyz", "xy", "polar", "stereographic", "lambert", "log"}
        All three components; the first two; the paper's pair (N₃, arg π(N)); stereographic
        real and imaginary part; Lambert's equal-area coordinates; the logarithm at the
        image's mean normal.
    method : {"difference", "plane", "quadric"}
        Central differences, or the least-squares plane or quadric over a disc.
    radius_px : float
        Radius of that disc, px, 1 … 15; no meaning for "difference".

    Returns
    -------
    (H, W, k) float32
        k = 3 for "xyz", else 2. N₁ points right, N₂ up, N₃ towards the camera, so N₃ ≥ 0. A
        pixel without a normal has the mean of the others, channel by channel.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        No pixel has a normal.

    References
    ----------
    The paper's eq. 3.7 and figure 6; maps: see `rangeface.numerics.sphere`.

    Examples
    --------
    A slope that rises away from the camera to the right has its normal to the right:

    >>> import numpy as np
    >>> from rangeface.types import Orthographic
    >>> slope = np.add.outer(np.zeros(5), 2.0 * np.arange(5))
    >>> normals(RangeImage(slope, Orthographic(2.0, 2, 2, 5, 5)))[2, 2].round(3) + 0.0
    array([0.707, 0.   , 0.707], dtype=float32)
    """
    if components not in COMPONENTS:
        raise ParameterError(f"components: must be one of {sorted(COMPONENTS)}, got {components!r}")
    flatten = COMPONENTS[components]
    return holes.fill_mean(flatten(gaussian_map(image, method=method, radius_px=radius_px)))


def gaussian_map(image: RangeImage, *, method: str, radius_px: float) -> Float32:
    """Normals (H, W, 3) in the feature frame, NaN where there is none; `normals` documents it."""
    pitch_mm = pitch_of(image)
    if method == "difference":
        found = estimate.from_depth_orthographic(image.depth, pitch_mm)
    elif method in METHODS:
        found = estimate.fit_orthographic(
            image.depth,
            pitch_mm,
            radius_px=radius_px,
            degree=1 if method == "plane" else 2,
            sigma=image.sigma,
        )
    else:
        raise ParameterError(f"method: must be one of {METHODS}, got {method!r}")
    return sphere.from_camera(found)
