"""Build the reference face that ships: `make reference`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rangeface import simulate
from rangeface.io.reference import save_reference
from rangeface.types import Float32, Mask, Orthographic, RangeImage, ReferenceFace

#: 2 mm a pixel, from 100 mm above the nose tip to 88 mm below, 78 mm to either side.
CAMERA = Orthographic(2.0, 39.0, 50.0, 79, 95)
#: Behind this depth (mm from the nose tip) a head is ear and neck, not face.
DEEPEST_MM = 105.0
PEOPLE = 200
#: Faces move; where they do, the reference should say little.
EXPRESSIONS = ("neutral", "smile", "neutral", "laugh", "neutral", "random")
PATH = Path(__file__).parents[1] / "data" / "reference.npz"


def build(people: int = PEOPLE) -> ReferenceFace:
    """Render the mean head, and measure how much people differ from it.

    Parameters
    ----------
    people : int
        Number of heads behind σ, with expressions, beards and fringes.

    Returns
    -------
    ReferenceFace
        Of the embedded population.
    """
    mean = simulate.mean_head()
    depth = _depth(mean)
    others = np.stack([_depth(_somebody(seed)) for seed in range(people)])
    deviation = _centred(others - depth)
    known = np.isfinite(deviation)
    square = np.where(known, deviation, 0.0) ** 2
    sigma = np.sqrt(square.sum(axis=0) / np.maximum(known.sum(axis=0), 1))
    usable = _usable(depth) & (known.sum(axis=0) >= people // 2)
    image = RangeImage(
        np.where(usable, depth, np.nan), CAMERA, sigma=np.where(usable, sigma, np.nan)
    )
    return ReferenceFace(image, mean.landmarks, f"mean of the embedded population, {people} heads")


def _somebody(seed: int) -> simulate.Head:
    """Neutral or not, every fifth with a beard, every fifth with a fringe."""
    expression = EXPRESSIONS[seed % len(EXPRESSIONS)]
    return simulate.head(seed, expression=expression, beard=seed % 5 == 1, fringe=seed % 5 == 3)


def _depth(head: simulate.Head) -> Float32:
    return simulate.render(head, CAMERA).image.depth


def _usable(depth: Float32) -> Mask:
    """Inside an ellipse from the hairline to the chin, 74 mm to either side; no ear, no neck."""
    x = (np.arange(CAMERA.width) - CAMERA.cx) * CAMERA.pitch_mm
    y = (np.arange(CAMERA.height) - CAMERA.cy) * CAMERA.pitch_mm
    ellipse = (x[None, :] / 74.0) ** 2 + ((y[:, None] + 6.0) / 88.0) ** 2 < 1.0
    return ellipse & (np.nan_to_num(depth, nan=np.inf) < DEEPEST_MM)


def _centred(difference: Float32) -> Float32:
    """Differences without their mean over the middle of the face: the nose tip's own length."""
    middle = difference[:, 20:75, 15:64]
    return np.asarray(difference - np.nanmean(middle, axis=(1, 2), keepdims=True))


if __name__ == "__main__":
    PATH.parent.mkdir(exist_ok=True)
    save_reference(PATH, build())
    print(f"{PATH.name}: {PATH.stat().st_size} bytes")
