"""The four profiles of the paper."""

from __future__ import annotations

import numpy as np

from rangeface.describe._horizontal_profile import horizontal_curves, root_height
from rangeface.describe._vertical_profile import vertical_curve
from rangeface.numerics import holes
from rangeface.types import Float32, RangeImage


def profiles(
    image: RangeImage,
    *,
    by: str = "symmetry",
    forehead_mm: float = 28.0,
    half_width_mm: float = 2.0,
    smooth_mm: float = 2.0,
    arc_length: bool = True,
) -> Float32:
    """The central vertical profile and the horizontal ones of nose, nose root and forehead.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    by : {"nose_tip", "symmetry"}
        How the central line is found, as for `vertical_profile`.
    forehead_mm : float
        Height of the last profile above the nose root, mm.
    half_width_mm, smooth_mm, arc_length
        As for `vertical_profile`.

    Returns
    -------
    (254,) float32
        mm behind the nose tip: 71 numbers of the vertical profile (± 70 mm), then 61 each of the
        horizontal ones (± 60 mm). A gap has the mean of its profile.

    Raises
    ------
    ParameterError
        The image is not frontal, or a parameter is out of range.
    DegenerateError
        The image has no valid pixel, or a profile meets none.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> flat = RangeImage(np.zeros((90, 60)), Orthographic(2.5, 30, 45, 60, 90))
    >>> profiles(flat).shape
    (254,)
    """
    vertical = vertical_curve(
        image, by=by, half_width_mm=half_width_mm, smooth_mm=smooth_mm, arc_length=arc_length
    )
    root_mm = root_height(image)
    horizontal = horizontal_curves(
        image,
        [0.0, root_mm, root_mm - forehead_mm],
        reach_mm=60.0,
        points=61,
        half_width_mm=half_width_mm,
        smooth_mm=smooth_mm,
        arc_length=arc_length,
    )
    return np.concatenate(
        [holes.fill_mean(vertical, axis=0), holes.fill_mean(horizontal, axis=1).ravel()]
    )
