"""`rangeface info` and `rangeface trace`: one scan, looked at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.table import Table

from rangeface.app.console import console
from rangeface.config import load_pipeline
from rangeface.evaluation.pictures import png, trace_figure
from rangeface.io import read_camera, read_scan
from rangeface.types import Pinhole, RangeImage


def info(file: Path, camera: Path | None) -> None:
    """Print what a scan holds, and whether a face was found or why not."""
    image = _read(file, camera)
    trace = load_pipeline("default").trace(image)
    table = Table(show_header=False, box=None)
    for name, value in _facts(file, image):
        table.add_row(name, value)
    if trace.assessment is not None:
        a = trace.assessment
        angles = f"yaw {a.yaw_deg:.0f}°, pitch {a.pitch_deg:.0f}°, roll {a.roll_deg:.0f}°"
        table.add_row("face", f"{angles}, nose tip at {a.distance_mm:.0f} mm")
        table.add_row("fit for a decision", "yes" if a.usable else f"no: {', '.join(a.refusals)}")
    else:
        table.add_row("face", f"none: {trace.reason}")
    console.print(table)


def draw_trace(file: Path, camera: Path | None, pipeline: str, out: Path) -> None:
    """Write the picture of every stage."""
    way = load_pipeline(pipeline)
    trace = way.trace(_read(file, camera))
    out.write_bytes(png(trace_figure(trace, way, title=file.name)))
    console.print(f"{out}: {trace.reason or 'face found'}", markup=False)


def _read(file: Path, camera: Path | None) -> RangeImage:
    return read_scan(file, camera=None if camera is None else read_camera(camera).camera)


def _facts(file: Path, image: RangeImage) -> list[tuple[str, str]]:
    camera, depth = image.camera, image.depth[image.mask]
    if isinstance(camera, Pinhole):
        lens = f"pinhole, fx {camera.fx:.1f}, fy {camera.fy:.1f} px"
    else:
        lens = f"orthographic, {camera.pitch_mm:g} mm a pixel"
    facts = [
        ("file", str(file)),
        ("size", f"{camera.width} × {camera.height} px"),
        ("camera", lens),
        ("valid pixels", f"{image.mask.sum()} ({100 * image.mask.mean():.0f} %)"),
        ("depth", f"{depth.min():.0f} … {depth.max():.0f} mm, median {np.median(depth):.0f} mm"),
    ]
    if image.sigma is not None:
        facts.append(("σ", f"median {np.nanmedian(image.sigma[image.mask]):.2f} mm"))
    if image.amplitude is not None:
        facts.append(("amplitude", f"median {np.nanmedian(image.amplitude[image.mask]):.0f}"))
    return facts
