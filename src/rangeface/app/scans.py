"""`rangeface info` and `rangeface trace`: one scan, looked at."""

from __future__ import annotations

from pathlib import Path

from rangeface.app.console import console
from rangeface.config import load_pipeline
from rangeface.evaluation.pictures import png, trace_figure
from rangeface.io import convert_scan, describe_scan, read_camera, read_scan
from rangeface.types import Camera


def info(
    file: Path, camera: Path | None, *, unit: str | None, front: str | None, up: str | None
) -> None:
    """Print what a scan holds, and whether a face was found or why not."""
    description = describe_scan(file, camera=_camera(camera), unit=unit, front=front, up=up)
    for name, fact in description.lines():
        console.print(f"{name}: {fact}", markup=False, highlight=False)
    trace = load_pipeline("default").trace(description.image)
    if trace.assessment is None:
        console.print(f"face: none ({trace.reason})", highlight=False)
        return
    a = trace.assessment
    angles = f"yaw {a.yaw_deg:.0f}°, pitch {a.pitch_deg:.0f}°, roll {a.roll_deg:.0f}°"
    console.print(f"face: {angles}, nose tip at {a.distance_mm:.0f} mm", highlight=False)
    verdict = "yes" if a.usable else f"no: {', '.join(a.refusals)}"
    console.print(f"fit for a decision: {verdict}", highlight=False)


def draw_trace(file: Path, camera: Path | None, pipeline: str, out: Path) -> None:
    """Write the picture of every stage."""
    way = load_pipeline(pipeline)
    trace = way.trace(read_scan(file, camera=_camera(camera)))
    out.write_bytes(png(trace_figure(trace, way, title=file.name)))
    console.print(f"{out}: {trace.reason or 'face found'}", markup=False)


def convert(
    source: Path,
    target: Path,
    camera: Path | None,
    *,
    unit: str | None,
    front: str | None,
    up: str | None,
) -> None:
    """Write a scan in another format."""
    convert_scan(source, target, camera=_camera(camera), unit=unit, front=front, up=up)
    console.print(f"{target}: {target.stat().st_size} bytes", markup=False, highlight=False)


def _camera(path: Path | None) -> Camera | None:
    return None if path is None else read_camera(path).camera
