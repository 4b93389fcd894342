"""More views of one capture: turned, and noisier, for learning from few."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from zlib import crc32

import numpy as np

from rangeface.denoise import sigma_map
from rangeface.numerics.se3 import rotation_matrix
from rangeface.pipeline._step import Step
from rangeface.types import Alignment, Face, RangeImage, RigidTransform


def turned(
    face: Face, alignment: Alignment, frontal: Step, angles_deg: Sequence[float]
) -> list[RangeImage]:
    """The face resampled after a rotation by every angle about each of the three axes.

    Parameters
    ----------
    face : Face
    alignment : Alignment
        Converged.
    frontal : Step
        (Face, Alignment) → frontal image.
    angles_deg : sequence of float

    Returns
    -------
    list of RangeImage
        3 · len(angles_deg) frontal images.
    """
    views = []
    for axis in np.eye(3):
        for angle in angles_deg:
            turn = RigidTransform(
                rotation_matrix(np.deg2rad(angle) * axis), np.zeros(3), source="face"
            )
            views.append(frontal(face, replace(alignment, transform=turn @ alignment.transform)))
    return views


def noisier(
    face: Face, alignment: Alignment, frontal: Step, multiples: Sequence[float]
) -> list[RangeImage]:
    """The face resampled with noise added before: multiples of every pixel's own σ.

    What is learned from a mean of frames, or from a clean scan, meets single frames: √(n − 1) makes
    one frame of a mean of n. The same capture is always given the same noise.

    Parameters
    ----------
    face : Face
        With the sensor's σ; where there is none, it is estimated from the image.
    alignment : Alignment
        Converged.
    frontal : Step
        (Face, Alignment) → frontal image.
    multiples : sequence of float
        ≥ 0, of σ.

    Returns
    -------
    list of RangeImage
        One frontal image a multiple.
    """
    image, sigma = face.image, sigma_map(face.image)
    rng = np.random.default_rng([0x0A06, crc32(image.depth.tobytes())])
    views = []
    for multiple in multiples:
        noise = multiple * sigma * rng.standard_normal(image.shape)
        seen = image.with_depth(image.depth + noise, sigma=np.hypot(1.0, multiple) * sigma)
        views.append(frontal(replace(face, image=seen), alignment))
    return views
