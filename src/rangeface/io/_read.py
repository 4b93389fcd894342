"""A scan file of any known format → range image or points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from rangeface.errors import ParameterError, RangeFaceError, ScanError, ScanFault
from rangeface.io import mcap
from rangeface.io._cloud import Cloud, point_set, source_unit_mm, view_rotation
from rangeface.io._formats import FORMATS, POINT_FORMATS, identify
from rangeface.io._grid import fit_pinhole
from rangeface.io._source import Limits, Source
from rangeface.io._virtual_camera import virtual_camera
from rangeface.numerics.polygons import grid_triangles
from rangeface.types import Camera, PointSet, RangeImage

_JUMP_MM = 12.0  # neighbours on a grid farther apart than this lie on two surfaces


def read_scan(
    path: str | Path | bytes,
    *,
    camera: Camera | None = None,
    unit: str | None = None,
    front: str | None = None,
    up: str | None = None,
    pitch_mm: float = 1.5,
    limits: Limits | None = None,
) -> RangeImage:
    r"""Read a scan of any known format; which one it is, its content says.

    Parameters
    ----------
    path : str, Path or bytes
        The file, or the contents of one; bytes have no camera file beside them.
    camera : Pinhole or Orthographic, optional
        Intrinsics of a depth image that brings none, or in place of those it brings; the
        virtual camera for points and meshes (default: orthographic, framing the main cluster).
    unit : str, optional
        Unit of the file's lengths, "um", "0.1mm", "mm", "cm", "m" or "in", where the format or
        its camera file does not state it or states it wrongly.
    front, up : str, optional
        The axes of a point or mesh file towards the viewer and the top of the head, such as
        "+z" and "+y"; by default what the format's users agree on.
    pitch_mm : float
        Pixel of the orthographic virtual camera, mm, > 0.
    limits : Limits, optional
        Caps on bytes, points, pixels, nesting and expansion.

    Returns
    -------
    RangeImage
        At least one pixel is valid. σ and amplitude where the format knows them.

    Raises
    ------
    ScanError
        The file is missing, broken, of no known format, over a limit, without a known unit or
        camera, or without a valid pixel; the message names it.
    ParameterError
        `front`, `up` or `pitch_mm` is impossible.

    Notes
    -----
    A mesh is drawn with a z-buffer; bare points as discs of their spacing. Islands and outliers
    far from the main cluster do not set the view.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> path = Path(tempfile.mkdtemp()) / "plane.obj"
    >>> _ = path.write_text("".join(f"v {x} {y} -700\n" for x in range(30) for y in range(30)))
    >>> image = read_scan(path)
    >>> type(image.camera).__name__, float(image.depth[10, 10])
    ('Orthographic', 700.0)
    """
    _, _, image = open_scan(
        path, camera=camera, unit=unit, front=front, up=up, pitch_mm=pitch_mm, limits=limits
    )
    return image


def open_scan(
    path: str | Path | bytes,
    *,
    camera: Camera | None,
    unit: str | None,
    front: str | None,
    up: str | None,
    pitch_mm: float,
    limits: Limits | None,
) -> tuple[Source, str, RangeImage]:
    """The source, the name of its format and the image: what `read_scan` reads, with its origin."""
    if not (np.isfinite(pitch_mm) and pitch_mm > 0):
        raise ParameterError(f"pitch_mm must be > 0, got {pitch_mm}")
    source = _unpacked(Source.open(path, limits, camera, unit))
    name, content = _parse(source)
    if isinstance(content, Cloud):
        image = _seen(source, name, content, front, up, pitch_mm)
    else:
        image = content
    if not image.mask.any():
        raise source.error(ScanFault.NO_VALID_PIXELS, f"none of {image.mask.size} pixels is valid")
    return source, name, image


def read_points(
    path: str | Path,
    *,
    camera: Camera | None = None,
    unit: str | None = None,
    front: str | None = None,
    up: str | None = None,
    limits: Limits | None = None,
) -> PointSet:
    """Read the points of a scan as they are, with the triangles between them if it has any.

    Parameters
    ----------
    path, camera, unit, front, up, limits
        As in `read_scan`; a depth image gives the points of its valid pixels.

    Returns
    -------
    PointSet
        Points in mm in the camera frame's axes (x right, y down, z forward).

    Raises
    ------
    ScanError
        As in `read_scan`.
    ParameterError
        `front` or `up` is impossible.
    """
    source = _unpacked(Source.open(path, limits, camera, unit))
    name, content = _parse(source)
    if isinstance(content, Cloud):
        return _points(source, name, content, front, up)
    points = content.points
    return point_set(source, points.reshape(-1, 3), grid_triangles(points, _JUMP_MM))


def read_frames(
    path: str | Path,
    *,
    camera: Camera | None = None,
    unit: str | None = None,
    limits: Limits | None = None,
) -> Iterator[RangeImage]:
    """Read the depth images of a recording one after the other; any other scan is one frame.

    Parameters
    ----------
    path, camera, unit, limits
        As in `read_scan`.

    Yields
    ------
    RangeImage
        Frames without a valid pixel included. A torn recording ends at the tear.

    Raises
    ------
    ScanError
        As in `read_scan`; a recording without a depth image has no valid pixels.
    """
    source = _unpacked(Source.open(path, limits, camera, unit))
    if not mcap.recognise(source):
        yield read_scan(path, camera=camera, unit=unit, limits=limits)
        return
    empty = True
    for image in mcap.frames(source):
        empty = False
        yield image
    if empty:
        raise source.error(ScanFault.NO_VALID_PIXELS, "no depth image in the recording")


def is_points(path: str | Path, *, limits: Limits | None = None) -> bool:
    """Whether a file's format holds points or meshes rather than depth images."""
    return identify(_unpacked(Source.open(path, limits))) in POINT_FORMATS


def _unpacked(source: Source) -> Source:
    """The source, its gzip opened and its byte order mark taken off."""
    if source.data[:2] == b"\x1f\x8b":
        source = replace(source, data=source.inflate([source.data], 31))
    if source.data[:3] == b"\xef\xbb\xbf":
        source = replace(source, data=source.data[3:])
    source.need(0, 1, "a scan")
    return source


def _seen(
    source: Source, name: str, cloud: Cloud, front: str | None, up: str | None, pitch_mm: float
) -> RangeImage:
    """Image of a cloud: on its own pixels if they are a camera's, else by a virtual camera."""
    own_axes = FORMATS[name].front == "-z" and front is None and up is None
    if source.camera is None and own_axes and cloud.points.ndim == 3:
        scale = source_unit_mm(source, FORMATS[name].unit)
        points = cloud.camera_points(scale, np.eye(3))
        camera = fit_pinhole(points)
        if camera is not None:
            return RangeImage(np.where(points[..., 2] > 0, points[..., 2], np.nan), camera)
    points_mm = _points(source, name, cloud, front, up)
    return virtual_camera(source, points_mm, camera=source.camera, pitch_mm=pitch_mm)


def _parse(source: Source) -> tuple[str, RangeImage | Cloud]:
    """Content of a source; whatever a reader trips over becomes a ScanError."""
    name = identify(source)
    try:
        with np.errstate(all="ignore"):  # wild numbers are found where they are checked
            return name, FORMATS[name].parse(source)
    except ScanError:
        raise
    except RangeFaceError as fault:
        raise source.error(ScanFault.MALFORMED, str(fault)) from None
    except MemoryError:
        raise source.error(ScanFault.TOO_LARGE, "not enough memory to read it") from None


def _points(source: Source, name: str, cloud: Cloud, front: str | None, up: str | None) -> PointSet:
    entry = FORMATS[name]
    scale = source_unit_mm(source, entry.unit)
    points = cloud.camera_points(scale, view_rotation(front or entry.front, up or entry.up))
    triangles = cloud.triangles
    if points.ndim == 3:
        triangles = grid_triangles(points, _JUMP_MM)
    return point_set(source, points.reshape(-1, 3), triangles)
