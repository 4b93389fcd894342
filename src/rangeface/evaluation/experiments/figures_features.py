"""Figures 5, 6, 7 and 9 of the paper, drawn from one frontal scan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rangeface import describe
from rangeface.errors import ParameterError
from rangeface.types import Float32, Orthographic, RangeImage

DOTS_PER_INCH = 110
PLACES = ("nose", "root", "forehead")

COLOURS = {
    "symmetry": "gold",
    "nose_tip": "crimson",
    "nose": "limegreen",
    "root": "tomato",
    "forehead": "hotpink",
}
"""Of the profiles, as in the paper's figure 9."""


def draw(image: RangeImage, folder: Path, *, sigma_mm: float = 0.5, seed: int = 0) -> list[Path]:
    """Draw the paper's feature figures of one frontal face.

    Parameters
    ----------
    image : RangeImage
        Frontal image.
    folder : Path
        Where the PNG files go; made if missing.
    sigma_mm : float
        Noise added for figure 5, mm.
    seed : int
        Of that noise.

    Returns
    -------
    list of Path
        figure5.png, figure6.png, figure7.png, figure9.png.

    Raises
    ------
    ParameterError
        The image is not frontal.
    DegenerateError
        The image has no valid pixel.
    """
    _camera(image)
    folder.mkdir(parents=True, exist_ok=True)
    figures = {
        "figure5.png": curvature_and_noise(image, sigma_mm, np.random.default_rng(seed)),
        "figure6.png": normal_components(image),
        "figure7.png": texture_features(image),
        "figure9.png": face_profiles(image),
    }
    for name, figure in figures.items():
        figure.savefig(folder / name, dpi=DOTS_PER_INCH)
    return [folder / name for name in figures]


def curvature_and_noise(image: RangeImage, sigma_mm: float, rng: np.random.Generator) -> Figure:
    """Figure 5: Gaussian curvature of a clean and of a noisy face, by differences and by fit."""
    noisy = image.with_depth(image.depth + rng.normal(0.0, sigma_mm, image.shape))
    panels = {}
    for title, face in (("clean", image), (f"σ = {sigma_mm:g} mm", noisy)):
        for method in ("difference", "fit"):
            panels[f"{title}, {method}"] = describe.curvature(face, kind="gaussian", method=method)
    limit = 2.0 * float(np.percentile(np.abs(panels["clean, fit"]), 95))
    return _panels(image, panels, columns=4, cmap="coolwarm", vmin=-limit, vmax=limit)


def normal_components(image: RangeImage) -> Figure:
    """Figure 6: the three Cartesian components of the normals."""
    N = describe.normals(image, method="quadric")
    panels = {f"$N_{i + 1}$": N[..., i] for i in range(3)}
    return _panels(image, panels, columns=3, cmap="gray", vmin=-1.0, vmax=1.0)


def texture_features(image: RangeImage) -> Figure:
    """Figure 7: range image, 3DLBP layers, gradients, LBP variants, as the paper defines them."""
    layers = describe.tdlbp(image, sigma_px=0.0)
    panels = {"a: range image": describe.depth_levels(image)}
    for i, letter in enumerate("bcde"):
        panels[f"{letter}: 3DLBP layer {i + 1}"] = layers[..., i]
    panels["f: HSO"] = describe.hso(image)
    panels["g: LHG"] = describe.lhg(image)
    for letter, points, radius_px, method in (
        ("h", 8, 1, "u2"),
        ("j", 16, 1, "u2"),
        ("i", 16, 2, "riu2"),
        ("k", 8, 1, "ri"),
        ("l", 8, 1, "riu2"),
    ):
        panels[f"{letter}: LBP {points},{radius_px} {method}"] = describe.lbp(
            image, points=points, radius_px=radius_px, method=method, sigma_px=0.0
        )
    return _panels(image, panels, columns=6, cmap="gray")


def face_profiles(image: RangeImage) -> Figure:
    """Figure 9: where the profiles are cut, and what they look like."""
    figure = Figure(figsize=(10.0, 4.5), layout="constrained")
    face, vertical, horizontal = figure.subplots(1, 3)
    extent = _extent(image)
    face.imshow(describe.n3(image), cmap="gray", vmin=0, vmax=1, extent=extent)
    offset_mm, roll = describe.symmetry_line(image)
    y = np.array([-70.0, 70.0])
    face.plot(offset_mm - y * np.tan(roll), y, color=COLOURS["symmetry"], linewidth=4)
    face.plot(0 * y, y, color=COLOURS["nose_tip"])
    for place in PLACES:
        face.axhline(describe.profile_height(image, place), color=COLOURS[place])
    face.set(xlim=extent[:2], ylim=extent[2:])
    for by in ("symmetry", "nose_tip"):
        curve = describe.vertical_curve(image, by=by)
        width = 4 if by == "symmetry" else 1.5
        heights = np.linspace(-70, 70, curve.size)
        vertical.plot(curve, heights, color=COLOURS[by], label=by, linewidth=width)
    for place in PLACES:
        curve = describe.horizontal_curve(image, at=place)
        horizontal.plot(np.linspace(-60, 60, curve.size), curve, color=COLOURS[place], label=place)
    vertical.set(xlabel="behind the nose tip, mm", ylabel="arc length, mm")
    horizontal.set(xlabel="arc length, mm", ylabel="behind the nose tip, mm")
    for axes in (vertical, horizontal):
        axes.invert_yaxis()
        axes.legend()
    return figure


def _camera(image: RangeImage) -> Orthographic:
    if not isinstance(image.camera, Orthographic):
        raise ParameterError("image: the figures need a frontal (orthographic) image")
    return image.camera


def _extent(image: RangeImage) -> tuple[float, float, float, float]:
    """Left, right, bottom, top of the image, mm, for y down."""
    camera = _camera(image)
    left, top = -(camera.cx + 0.5) * camera.pitch_mm, -(camera.cy + 0.5) * camera.pitch_mm
    return (
        left,
        left + camera.width * camera.pitch_mm,
        top + camera.height * camera.pitch_mm,
        top,
    )


def _panels(
    image: RangeImage,
    panels: dict[str, Float32],
    *,
    columns: int,
    cmap: str,
    vmin: float | None = None,
    vmax: float | None = None,
) -> Figure:
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(2.2 * columns, 3.4 * rows), layout="constrained")
    axes: list[Axes] = list(np.ravel(figure.subplots(rows, columns)))
    for ax, (title, values) in zip(axes, panels.items(), strict=False):
        shown = np.where(image.mask, values, np.nan)
        ax.imshow(shown, cmap=cmap, vmin=vmin, vmax=vmax, interpolation="nearest")
        ax.set_title(title, fontsize=9)
    for ax in axes:
        ax.set_axis_off()
    return figure
