"""From one gallery to another, whatever engines keep them."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import GalleryError, ScanError
from rangeface.gallery._protocol import Gallery
from rangeface.gallery._record import consent_from_text, consent_to_text, decode, encode
from rangeface.io.arrays import read_arrays, write_arrays


def export_gallery(gallery: Gallery, path: str | PathLike[str]) -> int:
    """Write everybody's templates and consents to a portable file.

    The file is **not encrypted** and holds biometric data; whoever has it can import it.

    Parameters
    ----------
    gallery : Gallery
        Source.
    path : str or PathLike
        File to write: a JSON header and raw arrays with hashes.

    Returns
    -------
    int
        Number of people.

    Raises
    ------
    GalleryError
        Nobody is enrolled, or the file cannot be written.
    """
    people = gallery.subjects()
    if not people:
        raise GalleryError(f"{path}: nothing to export, nobody is enrolled")
    records = [(i, encode(t)) for i, s in enumerate(people) for t in gallery.templates(s)]
    arrays: dict[str, NDArray[Any]] = {
        "owners": np.array([i for i, _ in records], dtype=np.int64),
        "lengths": np.array([len(r) for _, r in records], dtype=np.int64),
        "records": np.frombuffer(b"".join(r for _, r in records), dtype=np.uint8),
    }
    meta = {
        "kind": "gallery",
        "people": [[s, *consent_to_text(gallery.consent(s))] for s in people],
    }
    try:
        write_arrays(Path(path), meta, arrays)
    except OSError as error:
        raise GalleryError(f"{path}: {error.strerror}") from error
    gallery.note("exported")
    return len(people)


def import_gallery(gallery: Gallery, path: str | PathLike[str]) -> int:
    """Enrol everybody whom `export_gallery` wrote.

    Parameters
    ----------
    gallery : Gallery
        Target: of the same model, or empty; nobody of the file may be enrolled in it already.
    path : str or PathLike
        The file.

    Returns
    -------
    int
        Number of people.

    Raises
    ------
    GalleryError
        The file is missing, altered or no gallery, comes from another model, or somebody in it
        is enrolled already; then nobody was imported.
    """
    try:
        meta, arrays = read_arrays(Path(path))
    except ScanError as error:
        raise GalleryError(str(error)) from error
    if meta.get("kind") != "gallery":
        raise GalleryError(f"{path}: is no exported gallery")
    people = [
        (name, consent_from_text(reference, expires)) for name, reference, expires in meta["people"]
    ]
    twice = sorted(set(gallery.subjects()) & {name for name, _ in people})
    if twice:
        raise GalleryError(f"{path}: {twice[0]!r} is enrolled already; delete them here first")
    ends = np.cumsum(arrays["lengths"])
    gallery.enroll_many(
        (
            people[owner][0],
            decode(arrays["records"][end - length : end].tobytes()),
            people[owner][1],
        )
        for owner, length, end in zip(arrays["owners"], arrays["lengths"], ends, strict=True)
    )
    gallery.note("imported")
    return len(people)
