"""What do I need for 95 %? Recognition against noise, resolution, distance and frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rangeface import denoise, describe, register, sensors, simulate
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments._experiment import Experiment, Results, hits, rate
from rangeface.evaluation.experiments.clean_scans import mlda
from rangeface.evaluation.experiments.sources import Source, head_in, sitting
from rangeface.evaluation.experiments.stages import (
    SLICES,
    TURNS_DEG,
    WIDE,
    crops,
    frontals,
    recognition,
    scans,
)
from rangeface.evaluation.findings import Entry, Findings, Table
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.evaluation.pictures import heat_map, png
from rangeface.pipeline import Step, step
from rangeface.types import Pinhole, RangeImage

FACE_MM = 140.0
WANTED = 0.95
SIGMAS_MM = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
PIXELS = (15, 20, 30, 45, 70)
DISTANCES_MM = (400, 600, 900, 1300)
FRAMES = (1, 4, 16)
_CLOSE_MM = 400.0
_ICP = step(register.icp)
_FRONTAL = WIDE.step()
TITLE = "Operating map: what do I need for 95 %?"


@kept
def ideal(
    store: Store,
    *,
    source: Source,
    view: str,
    pixels: int,
    sigma_mm: float,
    denoise: Step,
    segment: Step = SLICES,
    register: Step = _ICP,
) -> Arrays:
    """Crops of faces before an ideal camera: `pixels` across 140 mm, white noise of σ."""
    f = _CLOSE_MM * pixels / FACE_MM
    width, height = 2 * pixels, int(2.5 * pixels)
    camera = Pinhole(f, f, (width - 1) / 2, (height - 1) / 2, width, height)

    def look(person: int) -> RangeImage:
        pose, rng = sitting(person, view, _CLOSE_MM)
        scene = simulate.render(head_in(source, person, view), camera, pose)
        return denoise(simulate.add_noise(scene.image, sigma_mm, rng=rng))

    return {"owner": np.arange(source.persons), **_frontals(source, look, segment, register)}


@kept
def tof(
    store: Store,
    *,
    source: Source,
    view: str,
    distance_mm: float,
    frames: int,
    segment: Step = SLICES,
    register: Step = _ICP,
) -> Arrays:
    """Crops of faces before a simulated SR-3000: so many frames averaged as phasors."""
    sensor = sensors.preset("sr3000")
    sensor = replace(sensor, camera=_window(sensor.camera, distance_mm))

    def look(person: int) -> RangeImage:
        pose, rng = sitting(person, view, distance_mm)
        scene = simulate.render(head_in(source, person, view), sensor.camera, pose, oversample=3)
        return denoise.combine.phasor_mean(list(simulate.frames(scene, sensor, frames, rng=rng)))

    return {"owner": np.arange(source.persons), **_frontals(source, look, segment, register)}


def _frontals(
    source: Source, look: Callable[[int], RangeImage], segment: Step, register: Step
) -> Arrays:
    return frontals(map(look, source.numbers), segment, register, _FRONTAL)


def _window(camera: Pinhole, distance_mm: float) -> Pinhole:
    """The part of the image that a head covers."""
    half = int(150.0 / camera.pixel_mm(distance_mm))
    left, top = max(int(camera.cx) - half, 0), max(int(camera.cy) - half, 0)
    right = min(int(camera.cx) + half, camera.width)
    bottom = min(int(camera.cy) + half, camera.height)
    return camera.crop(left, top, right - left, bottom - top)


def cells(source: Source) -> list[Cell]:
    """Every point of both maps, neutral and smiling."""
    source.need_heads("operating_map")
    views = source.probes.values()
    return [
        recognised(source, probe)
        for probe in (
            *(_ideal(source, v, p, s) for p, s, v in product(PIXELS, SIGMAS_MM, views)),
            *(_tof(source, v, d, n) for d, n, v in product(DISTANCES_MM, FRAMES, views)),
        )
    ]


def _ideal(source: Source, view: str, pixels: int, sigma_mm: float) -> Cell:
    way = step(denoise.auto)
    return cell(ideal, source=source, view=view, pixels=pixels, sigma_mm=sigma_mm, denoise=way)


def _tof(source: Source, view: str, distance_mm: float, frames: int) -> Cell:
    return cell(tof, source=source, view=view, distance_mm=float(distance_mm), frames=frames)


def recognised(source: Source, probes: Cell) -> Cell:
    """Our pipeline, enrolled from good scans."""
    training = tuple(
        cell(
            crops, scans=cell(scans, source=source, view=view), frontal=_FRONTAL,
            register=_ICP, turns_deg=TURNS_DEG,
        )
        for view in source.training
    )  # fmt: skip
    return cell(
        recognition, training=training, probes=probes, feature=step(describe.normals),
        classifier=mlda(100),
    )  # fmt: skip


def tabulate(source: Source, results: Results) -> Findings:
    """Both maps as tables and pictures, and what 95 % needs."""

    def at(make: Callable[..., Cell], *point: float) -> Rate:
        right = [
            hits(results(recognised(source, make(source, view, *point))))
            for view in source.probes.values()
        ]
        return rate(np.concatenate(right))

    def lost(make: Callable[..., Cell], *point: float) -> Rate:
        failed = [
            np.isnan(results(recognised(source, make(source, view, *point)))["scores"][:, 0, 0])
            for view in source.probes.values()
        ]
        return rate(np.concatenate(failed))

    ideals = [[at(_ideal, p, s) for s in SIGMAS_MM] for p in PIXELS]
    tofs = [[at(_tof, d, n) for n in FRAMES] for d in DISTANCES_MM]
    sigma_names, frame_names = [f"{s:g} mm" for s in SIGMAS_MM], [str(n) for n in FRAMES]
    tables = [
        _map("map-sigma-pixels", "pixels across 140 mm", PIXELS, sigma_names, ideals,
             "Rank 1 against σ of a pixel and resolution, ideal camera, % [95 %]"),
        _map("map-distance-frames", "distance, mm", DISTANCES_MM, frame_names, tofs,
             "Rank 1 of a simulated SR-3000 against distance and number of frames, % [95 %]"),
        _map("fta-sigma-pixels", "pixels across 140 mm", PIXELS, sigma_names,
             [[lost(_ideal, p, s) for s in SIGMAS_MM] for p in PIXELS],
             "Failures to acquire, ideal camera, % [95 %]; they count as errors above"),
        _map("fta-distance-frames", "distance, mm", DISTANCES_MM, frame_names,
             [[lost(_tof, d, n) for n in FRAMES] for d in DISTANCES_MM],
             "Failures to acquire, simulated SR-3000, % [95 %]; they count as errors above"),
        Table(
            "needs", f"What {100 * WANTED:g} % needs: neutral and smiling probes together",
            ["given", "the estimate reaches it", "the whole 95 % interval is above it"],
            [
                *_needs(PIXELS, "{} px across", ideals, SIGMAS_MM, "σ ≤ {:g} mm", last=True),
                *_needs(DISTANCES_MM, "SR-3000, {} mm", tofs, FRAMES, "{} frame(s)", last=False),
            ],
        ),
    ]  # fmt: skip
    figures = [
        (
            "Rank 1, %: σ of a pixel against pixels across the face; framed: at least 95 %",
            png(heat_map(_percent(ideals), sigma_names, list(map(str, PIXELS)), "σ", "pixels")),
        ),
        (
            "Rank 1, %: frames against distance, simulated SR-3000; framed: at least 95 %",
            png(
                heat_map(_percent(tofs), frame_names, list(map(str, DISTANCES_MM)), "frames", "mm")
            ),
        ),
    ]
    return Findings(
        TITLE, "Which sensor, resolution, distance and number of frames does a task need?",
        readings=[*READINGS, f"{2 * source.persons} probes a cell, {source.persons} enrolled."],
        tables=tables, figures=figures,
    )  # fmt: skip


def _map(
    name: str, corner: str, given: Sequence[int], columns: list[str], rates: list[list[Rate]],
    caption: str,
) -> Table:  # fmt: skip
    rows = [[str(g), *map(Entry, row)] for g, row in zip(given, rates, strict=True)]
    return Table(name, caption, [corner, *columns], rows)


def _needs(
    given: Sequence[int], words: str, rates: list[list[Rate]], choices: Sequence[float],
    answer: str, *, last: bool,
) -> list[list[str]]:  # fmt: skip
    """Per row, the least demanding choice that is good enough."""

    def least(good: list[bool]) -> str:
        found = [choice for choice, ok in zip(choices, good, strict=True) if ok]
        return answer.format(found[-1] if last else found[0]) if found else "not reached"

    return [
        [
            words.format(g),
            least([r.rate >= WANTED for r in row]),
            least([r.low >= WANTED for r in row]),
        ]
        for g, row in zip(given, rates, strict=True)
    ]


def _percent(rates: list[list[Rate]]) -> NDArray[np.float64]:
    return np.array([[100.0 * r.rate for r in row] for row in rates])


READINGS = (
    "Enrolled from two good scans a person (neutral and smiling, each with twelve rotations); "
    "probes are the neutral face of another day and a laugh, within a few degrees of frontal.",
    "First map: pinhole camera at 40 cm, white Gaussian noise of known σ, denoise.auto. n frames "
    "of such a camera are worth σ / √n.",
    "Second map: simulated SwissRanger SR-3000 with its systematic errors, frames averaged as "
    "phasors, nothing else denoised.",
    "Our pipeline: ICP, 140 × 224 mm on 50 × 80 pixels, all components of the normals, MLDA.",
)

EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=61, minutes=9.0)
