"""Models: the one that ships, training and calibration."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import rangeface
from rangeface import datasets
from rangeface.app.console import console
from rangeface.app.progress import over
from rangeface.config import load_pipeline
from rangeface.errors import DegenerateError
from rangeface.evaluation.protocol import Capture, acquire
from rangeface.evaluation.training import training_scans
from rangeface.recognizer import FaceRecognizer, default_recognizer
from rangeface.types import Scan


def load_model(path: Path | None) -> FaceRecognizer:
    """The model of a file, or the one that ships."""
    return FaceRecognizer.load(path) if path is not None else default_recognizer()


def train(out: Path, folder: Path | None, *, people: int, seed: int, pipeline: str) -> None:
    """Train on a folder's people, or on simulated ones, and write the model."""
    if folder is None:
        scans, others = training_scans(people, seed), training_scans(people, seed + 1)
        source = f"{people} simulated people, seed {seed}; thresholds from {people} others"
    else:
        scans = [s for s in datasets.folder(folder) if s.role in ("train", "gallery")]
        others, source = [], str(folder)
    recognizer = fit(pipeline, scans, source)
    if others:
        recognizer = _calibrated(recognizer, others)
    recognizer.save(out)
    console.print(f"{out}: {recognizer.provenance['people']} people, "
                  f"fingerprint {recognizer.pipeline.fingerprint[:12]}")  # fmt: skip
    if not others:
        console.print("not calibrated: run `rangeface calibrate` with a folder of other people")


def fit(pipeline: str, scans: Sequence[Scan], source: str) -> FaceRecognizer:
    """Fit a pipeline to scans; failures are counted."""
    way = load_pipeline(pipeline)
    captures = _acquired(acquire(way, over(scans, "finding faces")))
    adapted = way.adapted([c.trace for c in captures if c.trace is not None])
    if adapted is not way:
        way, captures = adapted, _acquired(acquire(adapted, over(scans, "registering again")))
    return FaceRecognizer.fit_traces(
        way,
        [c.trace for c in captures if c.trace is not None],
        [c.scan.subject for c in captures],
        provenance={
            "pipeline": pipeline,
            "source": source,
            "rangeface": rangeface.__version__,
            "python": platform.python_version(),
            "numpy": np.__version__,
        },
    )


def calibrate(folder: Path, *, fmr: float, model: Path | None, out: Path | None) -> None:
    """Learn non-mated scores from a folder of other people; print the threshold."""
    recognizer = _calibrated(load_model(model), datasets.folder(folder))
    target = out or model
    if target is not None:
        recognizer.save(target)
    pairs = recognizer.nonmated.size
    console.print(
        f"threshold at FMR {fmr:g}: {recognizer.threshold(fmr):.3f} ({pairs} comparisons)"
    )
    if target is None:
        console.print("not stored: the model that ships is read-only; give --out FILE")


def _calibrated(recognizer: FaceRecognizer, scans: Sequence[Scan]) -> FaceRecognizer:
    captures = _acquired(acquire(recognizer.pipeline, over(scans, "calibrating")))
    templates = [recognizer.template(c.trace) for c in captures if c.trace is not None]
    return recognizer.calibrate(templates, [c.scan.subject for c in captures])


def _acquired(captures: Sequence[Capture]) -> list[Capture]:
    usable = [c for c in captures if c.acquired]
    for failed in (c for c in captures if not c.acquired):
        console.print(f"left out {failed.scan.path}: {failed.failure}", style="yellow")
    if not usable:
        raise DegenerateError(f"none of {len(captures)} scans shows a face")
    return usable
