"""Points as a file states them, and their way into the camera frame and millimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError, ScanFault, UnitError
from rangeface.io._source import Source
from rangeface.numerics.pointset import compact, to_frame
from rangeface.types import PointSet

_UNIT_MM = {"um": 1e-3, "0.1mm": 0.1, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}

_FARTHEST_MM = 1e6  # a coordinate beyond a kilometre marks an invalid point

_AXES = {
    sign + name: direction * np.eye(3)[axis]
    for axis, name in enumerate("xyz")
    for sign, direction in (("+", 1.0), ("-", -1.0))
}


def unit_mm(unit: str) -> float:
    """Millimetres in a unit of length.

    Parameters
    ----------
    unit : str
        "um", "0.1mm", "mm", "cm", "m" or "in".

    Returns
    -------
    float
        Length of the unit, mm.

    Raises
    ------
    UnitError
        The unit is none of these.

    Examples
    --------
    >>> unit_mm("m")
    1000.0
    """
    try:
        return _UNIT_MM[unit]
    except (KeyError, TypeError):
        raise UnitError(f"unknown unit {unit!r}: one of {', '.join(_UNIT_MM)}") from None


def source_unit_mm(source: Source, default: str | None) -> float:
    """Millimetres in the unit that the caller, or else the format, states."""
    unit = source.unit or default
    if unit is None:
        raise source.error(
            ScanFault.UNKNOWN_UNIT, f"state one of {', '.join(_UNIT_MM)}; nothing is guessed"
        )
    try:
        return unit_mm(unit)
    except UnitError as fault:
        raise source.error(ScanFault.UNKNOWN_UNIT, str(fault)) from None


def view_rotation(front: str, up: str) -> NDArray[np.float64]:
    """Rotation that takes a file's axes to the camera's (x right, y down, z forward).

    Parameters
    ----------
    front : str
        The file's axis towards the viewer, out of the face: "+z", "-y", …
    up : str
        The file's axis towards the top of the head.

    Returns
    -------
    (3, 3) float64
        Signed permutation, det = +1.

    Raises
    ------
    ParameterError
        An axis is unknown, or both are the same line.

    Examples
    --------
    >>> view_rotation("+z", "+y").diagonal()
    array([ 1., -1., -1.])
    """
    for name, axis in (("front", front), ("up", up)):
        if axis not in _AXES:
            raise ParameterError(f"{name}: one of {', '.join(_AXES)}, got {axis!r}")
    z, y = -_AXES[front], -_AXES[up]
    if z @ y != 0.0:
        raise ParameterError(f"front, up: {front!r} and {up!r} lie on one line")
    return np.stack([np.cross(y, z), y, z]) + 0.0


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points in a file's own unit and axes; invalid ones not yet dropped.

    Parameters
    ----------
    points : (n, 3) or (H, W, 3) array_like
        An organised cloud keeps its grid; a non-finite coordinate marks an invalid point.
    triangles : (m, 3) array_like of int, optional
        Indices into the points, in row-major order for a grid.
    """

    points: NDArray[np.floating]
    triangles: NDArray[np.integer] | None = None

    def camera_points(self, scale_mm: float, rotation: ArrayLike) -> NDArray[np.float32]:
        """The points in mm and the camera's axes, same shape, NaN where invalid."""
        points = np.ascontiguousarray(self.points)
        if points.dtype != np.float32:
            points = points.astype(np.float64, copy=False)
        matrix = scale_mm * np.asarray(rotation, dtype=np.float64)
        return to_frame(points.reshape(-1, 3), matrix, _FARTHEST_MM).reshape(points.shape)


def point_set(source: Source, points: NDArray[np.float32], triangles: ArrayLike | None) -> PointSet:
    """The valid points (n, 3) mm, with the triangles that lie between them."""
    faces = np.empty((0, 3), np.int64) if triangles is None else np.asarray(triangles, np.int64)
    valid, kept, wrong = compact(points, faces)
    if wrong >= 0:
        raise source.error(
            ScanFault.MALFORMED, f"a face names a point that is not among the {len(points)}"
        )
    if not len(valid):
        raise source.error(ScanFault.NO_VALID_PIXELS, f"none of {len(points)} points is valid")
    return PointSet(valid, kept if len(kept) else None)


def check_indices(
    source: Source, triangles: NDArray[np.integer], count: int
) -> NDArray[np.integer]:
    """The triangles, refused if one names a point that does not exist."""
    if triangles.size and (triangles.min() < 0 or triangles.max() >= count):
        wrong = triangles.max() if triangles.max() >= count else triangles.min()
        raise source.error(
            ScanFault.MALFORMED, f"a face names point {wrong}, there are {count} points"
        )
    return triangles
