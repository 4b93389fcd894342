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
_MARGIN_MM = 30.0  # islands this close to the main cluster stay
_OVERDRAW = 16  # pixels that triangles may cover, in images of the largest size


def virtual_camera(
    source: Source, cloud: PointSet, *, camera: Camera | None, pitch_mm: float
) -> RangeImage:
    """Range image of a point set: the nearest surface in each pixel.

    Without a camera the view is orthographic and frames the main cluster: the largest set of
    points that hang together at 30 mm, or at four times the points' mean spacing where that is
    more. Islands and outliers farther than 30 mm from its box do not set the view and are left
    out; holes stay holes. With a camera, the points are taken to be in its frame.
    """
    points = cloud.points
    if camera is None:
        low, high = _main_box(points)
        inside = _within(points, low, high)
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


def _main_box(points: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Corners of the box around the largest cluster, margin included."""
    centre = np.median(points, axis=0)
    near = points[_within(points, centre - _REACH_MM, centre + _REACH_MM)]
    if not len(near):
        near = points
    sample = near[:: max(len(near) // 4096, 1)]
    spread = float(np.linalg.norm(np.ptp(np.quantile(sample, (0.05, 0.95), axis=0), axis=0)))
    cell = max(_CELL_MM, 4.0 * spread / np.sqrt(len(near)))
    origin = near.min(axis=0)
    cells = np.minimum(((near - origin) / cell).astype(np.int64), 255)
    shape = tuple(cells.max(axis=0) + 1)
    flat = np.ravel_multi_index(tuple(cells.T), shape)
    occupied = np.bincount(flat, minlength=int(np.prod(shape)))
    labels, count = ndimage.label(occupied.reshape(shape), structure=np.ones((3, 3, 3)))
    if count > 1:
        sizes = np.bincount(labels.ravel(), weights=occupied)
        near = near[labels.ravel()[flat] == 1 + sizes[1:].argmax()]
    return near.min(axis=0) - _MARGIN_MM, near.max(axis=0) + _MARGIN_MM


def _frame(
    source: Source, low: NDArray[np.float32], high: NDArray[np.float32], pitch_mm: float
) -> Orthographic:
    """Orthographic camera over the box, less the margin on all but one pixel."""
    size = (high - low - 2 * _MARGIN_MM)[:2]
    width, height = (int(n) for n in np.ceil(size / pitch_mm) + 3)
    if size.max() < 10.0:
        raise source.error(
            ScanFault.UNKNOWN_UNIT,
            f"the points span only {size.max():.3g} mm: state the unit (unit='m', …)",
        )
    if max(width, height) * pitch_mm > 2.5 * _REACH_MM:
        raise source.error(
            ScanFault.UNKNOWN_UNIT,
            f"the points span {size.max():.3g} mm: state the unit (unit='um', …) or a camera",
        )
    source.cap_pixels(width, height)
    cx, cy = 1.0 - (low + _MARGIN_MM)[:2] / pitch_mm
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
    depth, _, _ = rasterise(
        points,
        triangles,
        focal_px=(camera.fx, camera.fy)
        if isinstance(camera, Pinhole)
        else (1 / camera.pitch_mm, 1 / camera.pitch_mm),
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
