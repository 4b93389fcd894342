"""Pictures a person can judge: depth in colour, shaded surfaces, the stages of a trace."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rangeface.numerics.normals import from_points
from rangeface.pipeline import FacePipeline, Trace
from rangeface.types import Float32, RangeImage

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Light from above and the left, towards the scene.
_LIGHT = np.array([0.35, 0.5, 0.79], np.float32)
_BACKGROUND = 0.93


def depth_rgb(image: RangeImage, *, span_mm: float = 160.0) -> NDArray[np.float64]:
    """Depth in colours (H, W, 3): near is bright, `span_mm` behind the nearest 2 % is dark.

    Parameters
    ----------
    image : RangeImage
    span_mm : float
        Range that the colours cover, mm.

    Returns
    -------
    (H, W, 3) float64
        0 … 1; invalid pixels are light grey.
    """
    from matplotlib import colormaps

    out = np.full((*image.shape, 3), _BACKGROUND)
    if image.mask.any():
        near = np.nanpercentile(image.depth, 2.0)
        level = 1.0 - np.clip((image.depth - near) / span_mm, 0.0, 1.0)
        out[image.mask] = colormaps["viridis"](level[image.mask])[:, :3]
    return out


def shaded_rgb(image: RangeImage) -> NDArray[np.float64]:
    """The surface as a sculpture in oblique light, (H, W, 3) 0 … 1; invalid is light grey."""
    normals = from_points(image.points)
    light = np.clip(-(normals @ _LIGHT), 0.0, 1.0)
    seen = np.isfinite(light)
    out = np.full((*image.shape, 3), _BACKGROUND)
    out[seen] = (0.12 + 0.8 * light[seen])[:, None]
    return out


def feature_grey(feature: Float32, shape: tuple[int, int]) -> NDArray[np.float64] | None:
    """A feature that is an image as grey or RGB, 0 … 1; None if it is a vector."""
    pixels = shape[0] * shape[1]
    if feature.size % pixels or feature.size // pixels not in (1, 2, 3, 4):
        return None
    channels = feature.reshape(*shape, -1)[..., :3]
    low, high = channels.min(axis=(0, 1)), channels.max(axis=(0, 1))
    scaled = (channels - low) / np.maximum(high - low, 1e-9)
    return scaled if scaled.shape[-1] == 3 else np.repeat(scaled[..., :1], 3, axis=-1)


def trace_figure(trace: Trace, pipeline: FacePipeline, title: str = "") -> Figure:
    """Draw every stage of a trace, with its time, in one figure.

    Parameters
    ----------
    trace : Trace
        As far as it came.
    pipeline : FacePipeline
        That made it.
    title : str
        Above everything.

    Returns
    -------
    matplotlib Figure
    """
    panels = _panels(trace, pipeline)
    figure, axes = _figure(len(panels))
    for axis, (name, picture) in zip(axes, panels, strict=True):
        axis.imshow(picture, cmap="gray", interpolation="nearest")
        axis.set_title(name, fontsize=9)
        axis.set_axis_off()
    if trace.face is not None:
        _mark_face(axes[1], trace)
    times = "  ".join(f"{stage} {ms:.1f}" for stage, ms in trace.times_ms.items())
    outcome = f"stopped: {trace.reason}" if trace.frontal is None else _quality(trace)
    figure.suptitle(f"{title}\n{outcome}\nms: {times}", fontsize=9)
    return figure


def _panels(trace: Trace, pipeline: FacePipeline) -> list[tuple[str, Any]]:
    panels: list[tuple[str, Any]] = [
        ("depth", depth_rgb(trace.image)),
        (f"denoised: {pipeline.denoise.name}", shaded_rgb(trace.denoised)),
    ]
    if trace.image.amplitude is not None:
        panels.append(
            ("amplitude", np.log1p(np.nan_to_num(np.clip(trace.image.amplitude, 0, None))))
        )
    if trace.face is not None:
        panels.append(("face, sphere crop", shaded_rgb(trace.face.image)))
    if trace.frontal is not None:
        panels += [
            ("frontal", shaded_rgb(trace.frontal)),
            ("measured (white)", _measured(trace.frontal)),
        ]
        for head, feature in zip(pipeline.heads, trace.features, strict=True):
            picture = feature_grey(feature, trace.frontal.shape)
            if picture is not None:
                panels.append((f"feature: {head.describe.name}", picture))
    return panels


def _measured(frontal: RangeImage) -> NDArray[np.float64]:
    filled = np.zeros(frontal.shape, bool) if frontal.filled is None else frontal.filled
    return np.where(frontal.mask & ~filled, 1.0, 0.3)


def _mark_face(axis: Axes, trace: Trace) -> None:
    assert trace.face is not None
    camera = trace.denoised.camera
    u, v = camera.project(trace.face.nose_tip)
    axis.plot(u, v, "r+", markersize=9)
    for point in trace.face.landmarks.values():
        u, v = camera.project(point)
        axis.plot(u, v, ".", color="orange", markersize=3)
    axis.set_xlim(-0.5, camera.width - 0.5)
    axis.set_ylim(camera.height - 0.5, -0.5)


def _quality(trace: Trace) -> str:
    a = trace.assessment
    if a is None:
        return ""
    refusals = ", ".join(a.refusals)
    return (
        f"yaw {a.yaw_deg:.0f}°, pitch {a.pitch_deg:.0f}°, roll {a.roll_deg:.0f}°, "
        f"coverage {100 * a.coverage:.0f} %, overlap {100 * a.overlap:.0f} %, "
        f"σ {a.sigma_mm:.1f} mm, at {a.distance_mm:.0f} mm"
        + (f"; not fit for a decision: {refusals}" if refusals else "")
    )


def _figure(count: int) -> tuple[Figure, Sequence[Axes]]:
    figure = canvas((1.9 * count, 3.1))
    return figure, list(np.atleast_1d(figure.subplots(1, count)))


def heat_map(
    values: NDArray[np.float64],
    columns: Sequence[str],
    rows: Sequence[str],
    x: str,
    y: str,
    *,
    level: float = 95.0,
) -> Figure:
    """A table of percentages in colours, its numbers in it, cells from `level` on framed."""
    figure = canvas((1.1 * len(columns) + 1.6, 0.62 * len(rows) + 1.2))
    axis = figure.subplots()
    axis.imshow(values, cmap="viridis", vmin=0.0, vmax=100.0, aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        good = value >= level
        colour = "black" if value > 60.0 else "white"
        weight = "bold" if good else "normal"
        axis.text(column, row, f"{value:.0f}", ha="center", va="center", color=colour,
                  weight=weight)  # fmt: skip
        if good:
            axis.add_patch(_frame(column, row))
    axis.set_xticks(range(len(columns)), columns)
    axis.set_yticks(range(len(rows)), rows)
    axis.set(xlabel=x, ylabel=y)
    return figure


def _frame(column: int, row: int) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((column - 0.46, row - 0.46), 0.92, 0.92, fill=False, edgecolor="black", lw=1.5)


def canvas(size: tuple[float, float]) -> Figure:
    """An empty figure of this size, inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def png(figure: Figure, *, dpi: int = 110) -> bytes:
    """A figure as the bytes of a PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi)
    return buffer.getvalue()


def tile(pictures: Sequence[NDArray[np.float64]], titles: Sequence[str], *, columns: int) -> Figure:
    """Pictures side by side, row by row, each under its title."""
    rows = -(-len(pictures) // columns)
    figure = canvas((1.5 * columns, 1.75 * rows))
    axes = np.atleast_1d(figure.subplots(rows, columns)).ravel()
    for axis in axes:
        axis.set_axis_off()
    for axis, picture, title in zip(axes, pictures, titles, strict=False):
        axis.imshow(picture, interpolation="nearest")
        axis.set_title(title, fontsize=7)
    return figure
