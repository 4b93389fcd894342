"""`rangeface gallery`: rebuild it for another model, copy it, take it elsewhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.markup import escape

from rangeface.app.console import console
from rangeface.app.models import load_model
from rangeface.errors import GalleryError, NoFaceError
from rangeface.gallery import SqliteGallery, export_gallery, import_gallery, open_gallery
from rangeface.pipeline import Trace
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Assessment, Face, Faces, RangeImage, RigidTransform, Template

_AWAY_MM = 1000.0  # before the camera, as every scan is; a frontal image has its nose tip at 0


def rebuild(gallery: str, model: Path | None) -> None:
    """Make all templates anew from the frontal images that were kept."""
    recognizer = load_model(model)
    with open_gallery(gallery, create=False) as opened:
        count = opened.rebuild(lambda image, seen: template_of(recognizer, image, seen))
    fingerprint = recognizer.pipeline.fingerprint[:12]
    console.print(f"rebuilt {count} templates for model {fingerprint}", highlight=False)


def template_of(
    recognizer: FaceRecognizer, frontal: RangeImage, assessment: Assessment | None
) -> Template:
    """The template of a frontal image, registered again: the reference face may be another.

    Raises
    ------
    NoFaceError
        The model's registration refuses the image.
    """
    way = recognizer.pipeline
    image = frontal.with_depth(frontal.depth + _AWAY_MM)
    pose = RigidTransform(np.eye(3), np.array([0.0, 0.0, -_AWAY_MM]))
    face = Face(image, np.array([0.0, 0.0, _AWAY_MM]), pose=pose)
    alignment = way.register(face)
    if not alignment.converged:
        raise NoFaceError(f"a kept frontal image is refused: {alignment.reason}; enrol again")
    again = way.frontal(face, alignment)
    trace = Trace(image, image, Faces([face]), face, alignment, again, assessment)
    return recognizer.template(trace, augment=True)


def backup(gallery: str, target: Path, *, overwrite: bool) -> None:
    """Copy a gallery's file while others may be using it."""
    with open_gallery(gallery, create=False) as opened:
        if not isinstance(opened, SqliteGallery):
            raise GalleryError(f"{gallery}: has no file")
        opened.backup(target, overwrite=overwrite)
    console.print(f"{escape(str(target))}: a copy of {escape(gallery)}", highlight=False)


def export(gallery: str, target: Path) -> None:
    """Write everybody to a portable file."""
    with open_gallery(gallery, create=False) as opened:
        count = export_gallery(opened, target)
    console.print(f"{escape(str(target))}: {count} people, not encrypted", highlight=False)


def take_in(gallery: str, source: Path) -> None:
    """Enrol everybody of a portable file."""
    with open_gallery(gallery) as opened:
        count = import_gallery(opened, source)
    console.print(f"{escape(gallery)}: {count} people more", highlight=False)


def audit(gallery: str) -> None:
    """Print what was done; a person is a number."""
    with open_gallery(gallery, create=False) as opened:
        for entry in opened.audit():
            who = f"  person {entry.person}" if entry.person else ""
            console.print(f"{entry.at:%Y-%m-%d %H:%M:%S}  {escape(entry.action)}{who}",
                          highlight=False)  # fmt: skip
