"""`rangeface simulate` and `rangeface figures`: data and pictures that need no data."""

from __future__ import annotations

import csv
from pathlib import Path

from rich.progress import track

from rangeface import sensors, simulate
from rangeface.app.console import console
from rangeface.app.progress import err
from rangeface.config import load_pipeline
from rangeface.errors import NoFaceError, ParameterError
from rangeface.evaluation.experiments import (
    figures_denoise,
    figures_features,
    figures_simulation,
    figures_way,
)
from rangeface.io import read_scan, write_scan
from rangeface.types import RangeImage

#: The views of GavabDB's protocol: one frontal scan is enrolled, the others are probes.
GALLERY_VIEW = "frontal1"


def collection(out: Path, *, people: int, sensor: str, distance_mm: float, seed: int) -> None:
    """Write people × nine views as npz files with an index that `evaluate folder` reads."""
    if people < 1:
        raise ParameterError(f"people must be ≥ 1, got {people}")
    model = sensors.preset(sensor)
    out.mkdir(parents=True, exist_ok=True)
    captures = simulate.collection(
        range(1000 * seed, 1000 * seed + people), model, distance_mm=distance_mm, workers=2
    )
    count = people * len(simulate.VIEWS)
    with (out / "index.csv").open("w", newline="", encoding="utf-8") as file:
        index = csv.writer(file)
        index.writerow(["path", "subject", "role", "view", "session"])
        for shot in track(
            captures, "simulating", total=count, console=err, transient=True,
            disable=not err.is_terminal,
        ):  # fmt: skip
            name = f"{shot.person}-{shot.view}.npz"
            write_scan(out / name, shot.image)
            role = "gallery" if shot.view == GALLERY_VIEW else "probe"
            index.writerow([name, shot.person, role, shot.view, 0])
    console.print(f"{out}: {count} scans of {people} people", markup=False, highlight=False)


def figures(out: Path, *, scan: Path | None, seed: int) -> None:
    """Redraw the source paper's figures 2 to 12."""
    figures_simulation.run(seed=seed, folder=out)
    figures_features.draw(_frontal(scan, seed), out, seed=seed)
    figures_denoise.draw(out, person=seed, seed=seed)
    figures_way.draw(out, seed=seed)
    for path in sorted(out.glob("*.png")):
        console.print(str(path), markup=False, highlight=False)


def _frontal(scan: Path | None, seed: int) -> RangeImage:
    """The frontal image of the user's scan, or of a simulated one."""
    if scan is not None:
        image = read_scan(scan)
    else:
        camera = sensors.preset("laser-scanner").camera
        pose = simulate.pose(nose_tip_mm=(0.0, 0.0, 700.0))
        image = simulate.render(simulate.head(seed), camera, pose).image
    trace = load_pipeline("default").trace(image)
    if trace.frontal is None:
        raise NoFaceError(f"{scan or 'simulated head'}: {trace.reason}")
    return trace.frontal
