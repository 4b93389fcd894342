"""Figures 10 and 12 of the paper: noise of four strengths, and what the dual tree takes away.

One command draws both: ``python -m rangeface.evaluation.experiments.figures_denoise FOLDER``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rangeface import denoise, register
from rangeface.simulate import head, render
from rangeface.types import Float32, RangeImage

# one grey level of the paper's images: 14 cm on 255 levels
_GREY_MM = 140.0 / 255.0
_GREY_LEVELS = {"48.1 dB": 1, "42.1 dB": 2, "38.5 dB": 3, "34.1 dB": 5}


def draw(folder: Path, *, person: int = 11, seed: int = 0) -> list[Path]:
    """Draw both figures of a person who does not exist.

    Parameters
    ----------
    folder : Path
        Where the PNG files go; made if missing.
    person : int
        Number of the head, see `rangeface.simulate.head`.
    seed : int
        Of the noise.

    Returns
    -------
    list of Path
        figure10.png, figure12.png.
    """
    folder.mkdir(parents=True, exist_ok=True)
    camera = register.frontal.grid(140.0, 224.0, 50, 80)
    clean = render(head(person), camera).image
    noisy = {
        name: _noisy(clean, n * _GREY_MM, np.random.default_rng([seed, n]))
        for name, n in _GREY_LEVELS.items()
    }
    strong = noisy["34.1 dB"]
    figures = {
        "figure10.png": _panels({"clean": clean, **noisy}),
        "figure12.png": _panels(
            {
                "noisy, 34.1 dB": strong,
                "T = 2σ (eq. 3.5)": denoise.dtcwt(strong, shrinkage="soft"),
                "denoise.auto": denoise.auto(strong),
                "clean": clean,
            }
        ),
    }
    for name, figure in figures.items():
        figure.savefig(folder / name, dpi=110)
    return [folder / name for name in figures]


def _noisy(image: RangeImage, sigma_mm: float, rng: np.random.Generator) -> RangeImage:
    noise = rng.normal(0.0, sigma_mm, image.shape)
    return image.with_depth(image.depth + noise, sigma=np.full(image.shape, sigma_mm))


def _panels(images: dict[str, RangeImage]) -> Figure:
    """Depth in grey above, shaded as if lit from the camera below."""
    figure = Figure(figsize=(1.9 * len(images), 6.2), layout="constrained")
    axes = figure.subplots(2, len(images), squeeze=False)
    for (title, image), (top, bottom) in zip(images.items(), axes.T, strict=True):
        top.imshow(-image.depth, cmap="gray", vmin=-140.0, vmax=0.0, interpolation="nearest")
        bottom.imshow(_shaded(image), cmap="gray", vmin=0.0, vmax=1.0, interpolation="nearest")
        top.set_title(title, fontsize=9)
    for ax in np.ravel(axes):
        ax.set_axis_off()
    return figure


def _shaded(image: RangeImage) -> Float32:
    down, right = np.gradient(image.depth, 2.8)
    return 1.0 / np.sqrt(1.0 + down**2 + right**2)


if __name__ == "__main__":
    for path in draw(Path(sys.argv[1] if len(sys.argv) > 1 else ".")):
        print(path)
