"""A camera that was never there: points or a mesh → range image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from rangeface.errors import ScanFault
from rangeface.io._source import Source
from rangeface.numerics.pointset import covered
from rangeface.numerics.splat import splat
from rangeface.numerics.zbuffer import rasterise
from rangeface.types import Camera, Orthographic, Pinhole, PointSet, RangeImage

_CELL_MM = 30.0  # points closer than this are one thing
_REACH_MM = 1000.0  # nothing farther from the median point belongs to the scan
_MOST_CELLS = 127  # an axis; what lies beyond falls into the last one
_MARGIN_MM = 30.0  # so far behind or beside its box a point may still belong to its surface
_OVERDRAW = 16  # pixels that triangles may cover, in images of the largest size


def virtual_camera(
    source: Source, cloud: PointSet, *, camera: Camera | None, pitch_mm: float
) -> RangeImage:
    """Range image of a point set: the nearest surface in each pixel.

    Without a camera the view is orthographic and frames the main cluster: the largest set of
    points that hang together at 30 mm, or at four times the points' mean spacing where that is
    more, with large parts close to it. Other islands and outliers do not set the view, and what
    lies more than 30 mm outside its box is left out; holes stay holes. With a camera, the
    points are taken to be in its frame.
    """
    points = cloud.points
    if camera is None:
        low, high = _main_box(source, points)
        inside = _within(points, low - _MARGIN_MM, high + _MARGIN_MM)
        camera = _frame(source, low, high, pitch_mm)
    else:
        inside = np.ones(len(points), dtype=bool)
    source.cap_pixels(camera.width, camera.height)
    if cloud.triangles is None:
        depth = _splat_points(camera, points[inside])
    else:
        depth = _draw_mesh(
            source, camera, points, cloud.triangles[np.all(inside[cloud.triangles], axis=1)]
        )
    if not np.isfinite(depth).any():
        raise source.error(
            ScanFault.NO_VALID_PIXELS, "no point falls into the camera's view: check front, up"
        )
    return RangeImage(depth, camera)


def _within(
    points: NDArray[np.float32], low: NDArray[np.float32], high: NDArray[np.float32]
) -> NDArray[np.bool_]:
    inside = np.ones(len(points), dtype=bool)
    for axis in range(3):  # by column: a reduction over three is slow
        inside &= (points[:, axis] >= low[axis]) & (points[:, axis] <= high[axis])
    return inside


def _main_box(
    source: Source, points: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Corners of the box around the main cluster."""
    sample = points[:: max(len(points) // 4096, 1)]
    centre = np.median(sample, axis=0)
    spread = np.ptp(np.quantile(sample, (0.1, 0.9), axis=0), axis=0)
    if spread.max() > 2.0 * _REACH_MM:
        raise source.error(
            ScanFault.UNKNOWN_UNIT,
            f"the points span {spread.max():.3g} mm: state the unit (unit='um', …) or a camera",
        )
    near = points[_within(points, centre - _REACH_MM, centre + _REACH_MM)]
    near = near if len(near) else points
    cell = max(_CELL_MM, 4.0 * float(np.linalg.norm(spread)) / np.sqrt(len(near)))
    cells = np.minimum((near - near.min(axis=0)) / cell, _MOST_CELLS).astype(np.int64)
    near = near[_main_cluster(cells)]
    return near.min(axis=0), near.max(axis=0)


def _main_cluster(cells: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which points lie in the largest set of touching cells, or in a part of it split off.

    A part holds at least 5 % as many points and begins at most two cells away.
    """
    shape = tuple(cells.max(axis=0) + 1)
    flat = np.ravel_multi_index(tuple(cells.T), shape)
    occupied = np.bincount(flat, minlength=int(np.prod(shape)))
    labels, count = ndimage.label(occupied.reshape(shape), structure=np.ones((3, 3, 3)))
    sizes = np.bincount(labels.ravel(), weights=occupied, minlength=count + 1)
    main = int(sizes[1:].argmax()) + 1
    boxes = ndimage.find_objects(labels)
    kept = [
        k
        for k, box in enumerate(boxes, 1)
        if sizes[k] >= 0.05 * sizes[main] and _gap(box, boxes[main - 1]) <= 2
    ]
    return np.isin(labels.ravel()[flat], kept)


def _gap(a: tuple[slice, ...], b: tuple[slice, ...]) -> int:
    """Empty cells between two boxes along the axis where they are farthest apart."""
    return max(max(p.start - q.stop, q.start - p.stop) for p, q in zip(a, b, strict=True))


def _frame(
    source: Source, low: NDArray[np.float32], high: NDArray[np.float32], pitch_mm: float
) -> Orthographic:
    """Orthographic camera over the box, a pixel around it."""
    size = (high - low)[:2]
    if size.max() < 10.0:
        raise source.error(
            ScanFault.UNKNOWN_UNIT,
            f"the points span only {size.max():.3g} mm: state the unit (unit='m', …)",
        )
    width, height = (int(n) for n in np.ceil(size / pitch_mm) + 3)
    source.cap_pixels(width, height)
    cx, cy = 1.0 - low[:2] / pitch_mm
    return Orthographic(pitch_mm, float(cx), float(cy), width, height)


def _draw_mesh(
    source: Source, camera: Camera, points: NDArray[np.float32], triangles: NDArray[np.int32]
) -> NDArray[np.float32]:
    area = covered(camera.project(points), triangles, camera.width, camera.height)
    most = _OVERDRAW * source.limits.max_pixels
    if area > most:
        raise source.error(
            ScanFault.TOO_LARGE, f"the triangles cover {area:.3g} px, the limit is {most:.3g}"
        )
    perspective = isinstance(camera, Pinhole)
    scale = (camera.fx, camera.fy) if isinstance(camera, Pinhole) else (1 / camera.pitch_mm,) * 2
    depth, _, _ = rasterise(
        points,
        triangles,
        focal_px=scale,
        centre_px=(camera.cx, camera.cy),
        size_px=(camera.width, camera.height),
        perspective=perspective,
    )
    return depth


def _splat_points(camera: Camera, points: NDArray[np.float32]) -> NDArray[np.float32]:
    pixels = camera.project(points)
    return splat(
        pixels,
        points[:, 2],
        shape=(camera.height, camera.width),
        radius_px=_spacing_px(pixels, camera),
    )


def _spacing_px(pixels: NDArray[np.float64], camera: Camera) -> float:
    """Distance between neighbouring points in the image, 0.75 to 4 px, from blocks of 4 px."""
    block = 4
    inside = ((pixels >= 0) & (pixels < (camera.width, camera.height))).all(axis=1)
    cells = (pixels[inside] / block).astype(np.int64)
    counts = np.bincount(cells[:, 1] * (camera.width // block + 1) + cells[:, 0])
    counts = counts[counts > 0]
    if not counts.size:
        return 1.0
    return float(np.clip(1.5 * block / np.sqrt(np.median(counts)), 0.75, 4.0))
