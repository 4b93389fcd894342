"""How sure it is that a pose shows a face: a logistic regression on what speaks for and against."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from rangeface.numerics import icp
from rangeface.numerics.projection import Projection
from rangeface.numerics.se3 import head_angles
from rangeface.types import Float32, Float64

#: Log odds per unit of each cue: fitted to 100 simulated faces (turned by up to 55°, with
#: expressions, clean and with time-of-flight noise), wrong poses on them, 300 face-free scenes.
WEIGHTS: Mapping[str, float] = MappingProxyType(
    {
        "bias": -16.57,
        "fit": 5.26,
        "relief": 9.94,
        "steepness": 4.36,
        "oddity": -5.46,
        "bend": -4.32,
        "visible": 9.65,
        "behind": -27.15,
        "before": -14.88,
        "missing": -6.3,
        "roll": -2.48,
    }
)


def cues(
    model: icp.Model,
    rotation: Float64,
    translation: Float64,
    projection: Projection,
    points: Float32,
) -> dict[str, float]:
    """What speaks for and against a face in this pose (camera←face).

    Shares of the visible part of the reference: explained within 8 mm, seen through to a surface
    far behind, hidden, not measured; the visible share itself; correlation and steepness of the
    relief, and how far the steepness is from 1; how much more or less the surface bends; and
    the square of the roll, in units of 30°.
    """
    seen = icp.evidence(model, rotation, translation, projection, points, tolerance_mm=8.0)
    relief = icp.relief(model, rotation, translation, projection, points)
    visible = max(seen.visible, 0.05)
    return {
        "bias": 1.0,
        "fit": seen.explained / visible,
        "relief": relief.correlation,
        "steepness": min(relief.steepness, 2.0),
        "oddity": min((relief.steepness - 1.0) ** 2, 1.0),
        "bend": math.log1p(relief.bend / 10.0),
        "visible": seen.visible,
        "behind": seen.behind / visible,
        "before": seen.before / visible,
        "missing": seen.missing / visible,
        "roll": (np.rad2deg(head_angles(rotation)[2]) / 30.0) ** 2,
    }


def confidence(found: Mapping[str, float]) -> float:
    """Probability, 0 … 1, that a pose with these cues shows a face."""
    odds = sum(WEIGHTS[name] * value for name, value in found.items())
    return 1.0 / (1.0 + math.exp(-min(max(odds, -50.0), 50.0)))
