"""One scan format → another."""

from __future__ import annotations

from pathlib import Path

from rangeface.errors import ParameterError
from rangeface.io._read import is_points, read_frames, read_points, read_scan
from rangeface.io._source import Limits
from rangeface.io._write import WRITERS, write_frames, write_points, write_scan
from rangeface.types import Camera


def convert_scan(
    path: str | Path,
    target: str | Path,
    *,
    camera: Camera | None = None,
    unit: str | None = None,
    front: str | None = None,
    up: str | None = None,
    pitch_mm: float = 1.5,
    limits: Limits | None = None,
) -> None:
    """Read a scan and write it in the format that the target's ending names.

    Points and meshes become a PLY as they are and a range image in every other format; the
    depth images of a recording stay a recording in MCAP, elsewhere the first is taken.

    Parameters
    ----------
    path : str or Path
        The scan.
    target : str or Path
        The file to write: ``.npz``, ``.png``, ``.ply`` or ``.mcap``.
    camera, unit, front, up, pitch_mm, limits
        As in `read_scan`.

    Raises
    ------
    ScanError
        As in `read_scan`.
    ParameterError
        As in `read_scan` and `write_scan`.
    """
    target = Path(target)
    if target.suffix.lower() not in WRITERS:
        raise ParameterError(f"target: ending {target.suffix!r}, not one of {', '.join(WRITERS)}")
    if target.suffix.lower() == ".ply" and is_points(path, limits=limits):
        points = read_points(path, unit=unit, front=front, up=up, limits=limits)
        write_points(target, points)
    elif target.suffix.lower() == ".mcap" and not is_points(path, limits=limits):
        frames = read_frames(path, camera=camera, unit=unit, limits=limits)
        write_frames(target, list(frames))
    else:
        image = read_scan(
            path, camera=camera, unit=unit, front=front, up=up, pitch_mm=pitch_mm, limits=limits
        )
        write_scan(target, image)
