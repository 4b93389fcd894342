"""Figures 4, 8 and 11 of the paper: segmentation, the symmetry plane, a time-of-flight image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rangeface import denoise, describe, register, segment, sensors, simulate
from rangeface.errors import NoFaceError
from rangeface.evaluation.experiments.sources import SCANNER, SCANNER_MM, scanner
from rangeface.evaluation.experiments.stages import RECTANGLE, SPHERE, Crop
from rangeface.evaluation.pictures import canvas, depth_rgb, shaded_rgb
from rangeface.segment._slices import regions
from rangeface.types import Face, RangeImage

_FRAMES = 10  # of a time-of-flight camera, averaged as the paper does


def draw(folder: Path, *, seed: int = 0) -> list[Path]:
    """Draw the figures of a simulated person.

    Parameters
    ----------
    folder : Path
        Where the PNG files go; made if missing.
    seed : int
        Number of the person.

    Returns
    -------
    list of Path
        figure4.png, figure8.png, figure11.png.
    """
    folder.mkdir(parents=True, exist_ok=True)
    figures = {
        "figure4.png": segmentation(seed),
        "figure8.png": symmetry_plane(seed),
        "figure11.png": time_of_flight(seed),
    }
    for name, figure in figures.items():
        figure.savefig(folder / name, dpi=110)
    return [folder / name for name in figures]


def segmentation(seed: int) -> Figure:
    """Figure 4: a region of a range slice, the sphere crop, the rectangle crop."""
    image = _scan(seed, yaw_deg=8.0)
    face = _face(image)
    region = next(iter(regions(image, 60.0)))
    return _panels(
        {
            "scan": depth_rgb(image),
            "(a) region of a range slice": depth_rgb(image.masked(region)),
            "(b) sphere, 14 cm": shaded_rgb(face.image),
            "(b) on 50 × 80 pixels": shaded_rgb(_crop(face, SPHERE)),
            "(c) rectangle, 100 × 160 mm": shaded_rgb(_crop(face, RECTANGLE)),
        }
    )


def symmetry_plane(seed: int) -> Figure:
    """Figure 8: where a tilted face's plane of mirror symmetry cuts it."""
    frontal = _crop(_face(_scan(seed, roll_deg=9.0)), RECTANGLE)
    offset_mm, roll = describe.symmetry_line(frontal)
    figure = _panels({"symmetry line of a face tilted by 9°": shaded_rgb(frontal)})
    axis, camera = figure.axes[0], frontal.camera
    rows = np.array([0.0, camera.height - 1.0])
    middle = camera.cx + offset_mm / np.cos(roll) / RECTANGLE.pitch_mm
    axis.plot(middle - (rows - camera.cy) * np.tan(roll), rows, color="gold", lw=2)
    axis.set_xlim(-0.5, camera.width - 0.5)
    return figure


def time_of_flight(seed: int) -> Figure:
    """Figure 11: one frame of an SR-3000, the mean of ten, and its 50 × 80 face segment."""
    sensor, rng = sensors.preset("sr3000"), np.random.default_rng(seed)
    scene = simulate.render(
        simulate.head(seed), sensor.camera, simulate.pose(nose_tip_mm=(0.0, 0.0, 400.0)),
        oversample=3,
    )  # fmt: skip
    frames = list(simulate.frames(scene, sensor, _FRAMES, rng=rng))
    mean = denoise.combine.mean(frames)
    return _panels(
        {
            "one frame, 176 × 144": depth_rgb(frames[0]),
            "the same, shaded": shaded_rgb(frames[0]),
            f"mean of {_FRAMES}, shaded": shaded_rgb(mean),
            "face segment, 50 × 80": shaded_rgb(_crop(_face(mean), RECTANGLE)),
        }
    )


def _scan(seed: int, *, yaw_deg: float = 0.0, roll_deg: float = 0.0) -> RangeImage:
    pose = simulate.pose(yaw_deg=yaw_deg, roll_deg=roll_deg, nose_tip_mm=(0.0, 0.0, SCANNER_MM))
    scene = simulate.render(simulate.head(seed), SCANNER, pose)
    return simulate.capture(scene, scanner(), rng=np.random.default_rng(seed))


def _face(image: RangeImage) -> Face:
    faces = segment.slices(image)
    if not faces:
        raise NoFaceError(f"nothing to draw: {faces.reason}")
    return faces[0]


def _crop(face: Face, crop: Crop) -> RangeImage:
    shown: RangeImage = crop.step()(face, register.none(face))
    return shown


def _panels(pictures: dict[str, np.ndarray]) -> Figure:
    figure = canvas((2.6 * len(pictures), 3.4))
    axes = np.atleast_1d(figure.subplots(1, len(pictures)))
    for axis, (name, picture) in zip(axes, pictures.items(), strict=True):
        axis.imshow(picture, interpolation="nearest")
        axis.set_title(name, fontsize=9)
        axis.set_axis_off()
    return figure
