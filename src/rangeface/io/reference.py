"""Reference faces: read, written, and the one that ships."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import as_file, files
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from rangeface.errors import ScanError, ScanFault
from rangeface.types import Orthographic, RangeImage, ReferenceFace


@lru_cache(maxsize=1)
def default_reference() -> ReferenceFace:
    """The mean head of the embedded population, as `make reference` builds it.

    Returns
    -------
    ReferenceFace
    """
    with as_file(files("rangeface") / "data" / "reference.npz") as path:
        return load_reference(path)


def save_reference(path: Path, reference: ReferenceFace) -> None:
    """Write a reference face: depth in 0.01 mm, σ in 0.01 mm, camera and landmarks as JSON.

    Parameters
    ----------
    path : Path
        File to write (.npz).
    reference : ReferenceFace
        Depth and σ below 327 mm.
    """
    header = reference_header(reference)
    planes: dict[str, Any] = {"depth": _packed(reference.image.depth)}
    if reference.image.sigma is not None:
        planes["sigma"] = _packed(reference.image.sigma)
    np.savez_compressed(
        path, header=np.frombuffer(json.dumps(header, sort_keys=True).encode(), np.uint8), **planes
    )


def load_reference(path: Path) -> ReferenceFace:
    """Read a reference face that `save_reference` wrote.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    ReferenceFace

    Raises
    ------
    ScanError
        The file is missing, or is no reference face.
    """
    if not path.exists():
        raise ScanError(path, ScanFault.MISSING, "build it with `make reference`")
    try:
        with np.load(BytesIO(path.read_bytes()), allow_pickle=False) as file:
            header = json.loads(bytes(file["header"]))
            depth = _unpacked(file["depth"])
            sigma = _unpacked(file["sigma"]) if "sigma" in file else None
        return reference_from(header, depth, sigma)
    except (OSError, ValueError, KeyError, TypeError, BadZipFile) as error:
        raise ScanError(path, ScanFault.MALFORMED, f"no reference face ({error})") from error


def reference_header(reference: ReferenceFace) -> dict[str, Any]:
    """Everything of a reference face that is no array, as JSON can say it."""
    camera = reference.image.camera
    return {
        "name": reference.name,
        "camera": {k: getattr(camera, k) for k in ("pitch_mm", "cx", "cy", "width", "height")},
        "landmarks": {k: [round(float(x), 3) for x in v] for k, v in reference.landmarks.items()},
    }


def reference_from(
    header: Mapping[str, Any], depth: np.ndarray, sigma: np.ndarray | None
) -> ReferenceFace:
    """The reference face of a header (as `reference_header` makes it) and its planes."""
    image = RangeImage(depth, Orthographic(**header["camera"]), sigma=sigma)
    landmarks = {name: np.array(point) for name, point in header["landmarks"].items()}
    return ReferenceFace(image, landmarks, header["name"])


_HOLE = np.int16(-32768)


def _packed(plane: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(plane), np.rint(np.nan_to_num(plane) * 100.0), _HOLE).astype("<i2")


def _unpacked(plane: np.ndarray) -> np.ndarray:
    return np.where(plane == _HOLE, np.nan, plane.astype(np.float32) / 100.0)
