"""Figures 2 and 3 of the paper, redrawn from our own simulated people."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rangeface import sensors, simulate
from rangeface.types import Orthographic, PointSet, RangeImage

DOTS_PER_INCH = 110
LAMP = np.array([-0.35, -0.5, -0.8])


def run(*, seed: int = 0, folder: str | Path = "figures") -> dict[str, Any]:
    """Draw both figures.

    Parameters
    ----------
    seed : int
        Number of the person, and seed of the noise.
    folder : str or Path
        Where figure2.png and figure3.png go; made if missing.

    Returns
    -------
    dict
        Paths of the files.
    """
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    figures = {"figure2.png": figure2(seed), "figure3.png": figure3(seed)}
    for name, figure in figures.items():
        figure.savefig(target / name, dpi=DOTS_PER_INCH)
    return {name: str(target / name) for name in figures}


def figure2(seed: int = 0) -> Figure:
    """From a clean scan to time-of-flight quality, step by step."""
    camera = Orthographic(0.5, 159.5, 219.5, 320, 440)
    clean = simulate.render(simulate.head(seed), camera).image
    steps = simulate.degrade(clean, rng=np.random.default_rng(seed))
    figure = Figure(figsize=(3.0 * len(steps), 8.4), layout="constrained")
    axes = figure.subplots(2, len(steps))
    for column, (name, image) in enumerate(steps.items()):
        _show(axes[0, column], np.nan_to_num(1.0 - image.depth / 120.0), name)
        _show(axes[1, column], shaded(image), "shaded")
    return figure


def figure3(seed: int = 0) -> Figure:
    """One face before an SR-3000: without noise, the paper's model, every effect, ten frames."""
    sensor, paper = sensors.preset("sr3000"), sensors.preset("paper")
    surfaces: list[simulate.Head | PointSet] = [simulate.head(seed), simulate.wall(1200.0)]
    scene = simulate.render(surfaces, sensor.camera, [simulate.pose(), None], oversample=3)
    rng = np.random.default_rng(seed)
    frames = [simulate.tof(scene, sensor, rng=rng) for _ in range(10)]
    mean = np.mean([frame.depth for frame in frames], axis=0)
    views = {
        "without noise": scene.image,
        "the paper's model": simulate.capture(scene, paper, rng=rng),
        "SR-3000, one frame": frames[0],
        "SR-3000, ten frames": frames[0].with_depth(mean),
    }
    figure = Figure(figsize=(15.0, 4.2), layout="constrained")
    axes = figure.subplots(1, len(views) + 1)
    for place, (name, image) in zip(axes, views.items(), strict=False):
        near = image.masked(np.nan_to_num(image.depth, nan=np.inf) < 620.0)
        _show(place, shaded(near), name)
    _show(axes[-1], _unit(np.asarray(frames[0].amplitude)), "amplitude")
    return figure


def shaded(image: RangeImage) -> NDArray[np.float64]:
    """Surface of a range image under a lamp, 0 … 1; white where nothing was measured."""
    along_v, along_u = (np.gradient(image.points, axis=axis) for axis in (0, 1))
    normal = np.cross(along_v, along_u)
    with np.errstate(invalid="ignore"):
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    light = np.clip(normal @ (LAMP / np.linalg.norm(LAMP)), 0.0, 1.0)
    return np.where(np.isfinite(light), 0.1 + 0.9 * light, 1.0)


def _unit(plane: NDArray[Any]) -> NDArray[Any]:
    return np.clip(plane / np.quantile(plane, 0.995), 0.0, 1.0)


def _show(axes: Axes, picture: NDArray[Any], title: str) -> None:
    axes.imshow(picture, cmap="gray", vmin=0.0, vmax=1.0)
    axes.set_title(title, fontsize=10)
    axes.set_axis_off()
