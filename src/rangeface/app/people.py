"""enroll, verify, identify, list, delete: what they print."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from rich.markup import escape

from rangeface.app.console import console
from rangeface.app.models import load_model
from rangeface.errors import GalleryError, NoFaceError
from rangeface.gallery import open_gallery
from rangeface.io import read_camera, read_scan
from rangeface.pipeline import Trace
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Decision, Verdict

_COLOURS = {Verdict.ACCEPTED: "green", Verdict.UNKNOWN: "red", Verdict.CANNOT_TELL: "yellow"}


def enroll(
    subject: str,
    files: Sequence[Path],
    gallery: str,
    model: Path | None,
    camera: Path | None,
    *,
    keep_frontal: bool,
) -> None:
    """Enrol; the line is printed only after the template is safe on the disk."""
    recognizer = load_model(model)
    with open_gallery(gallery) as opened:
        trace = look(recognizer, files, camera)
        if trace.frontal is None:
            raise NoFaceError(f"{files[0]}: not enrolled: {trace.reason}")
        if trace.assessment is not None and not trace.assessment.usable:
            reasons = ", ".join(trace.assessment.refusals)
            raise NoFaceError(f"{files[0]}: not enrolled: {reasons}")
        template = recognizer.template(trace, augment=True)
        opened.enroll(subject, template, frontal=trace.frontal if keep_frontal else None)
        count = len(opened.subjects())
    console.print(f"enrolled {escape(subject)} ({count} people in {escape(gallery)})")


def verify(
    subject: str,
    files: Sequence[Path],
    gallery: str,
    fmr: float,
    model: Path | None,
    camera: Path | None,
) -> None:
    """Print the decision; exit status 1 unless accepted."""
    recognizer = load_model(model)
    with open_gallery(gallery, create=False) as opened:
        trace = look(recognizer, files, camera)
        _answer(recognizer.verify(trace, subject, opened, fmr=fmr))


def identify(
    files: Sequence[Path], gallery: str, fmr: float, model: Path | None, camera: Path | None
) -> None:
    """Print the decision; exit status 1 unless accepted."""
    recognizer = load_model(model)
    with open_gallery(gallery, create=False) as opened:
        trace = look(recognizer, files, camera)
        _answer(recognizer.identify(trace, opened, fmr=fmr))


def show(gallery: str) -> None:
    """Print who is enrolled, with the number of templates."""
    with open_gallery(gallery, create=False) as opened:
        for subject in opened.subjects():
            console.print(f"{escape(subject)}  {len(opened.templates(subject))}")


def delete(subject: str, gallery: str) -> None:
    """Delete a person; it is an error if nobody of that name is enrolled."""
    with open_gallery(gallery, create=False) as opened:
        if subject not in opened.subjects():
            raise GalleryError(f"{gallery}: {subject!r} is not enrolled")
        count = opened.delete(subject)
    console.print(f"deleted {escape(subject)} ({count} templates)")


def look(recognizer: FaceRecognizer, files: Sequence[Path], camera: Path | None) -> Trace:
    """Read the scan, or the frames that are combined, and follow the face in it."""
    intrinsics = None if camera is None else read_camera(camera).camera
    frames = [read_scan(file, camera=intrinsics) for file in files]
    return recognizer.pipeline.trace(frames[0] if len(frames) == 1 else frames)


def _answer(decision: Decision) -> None:
    who = f" {escape(decision.subject)}" if decision.subject else ""
    why = f": {decision.reason}" if decision.reason else ""
    colour = _COLOURS[decision.verdict]
    console.print(f"[{colour}]{decision.verdict}{who}[/]{why}", highlight=False)
    console.print(
        f"score {decision.score:.2f}, threshold {decision.threshold:.2f}", highlight=False
    )
    for subject, score in decision.ranking[:5]:
        console.print(f"  {score:8.2f}  {escape(subject)}", highlight=False)
    if decision.verdict is not Verdict.ACCEPTED:
        sys.exit(1)
