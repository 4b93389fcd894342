"""A few frames of one face → one image of it, at a size that is worth its while."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rangeface.denoise.combine import motion_compensated_mean
from rangeface.live._box import box
from rangeface.types import Float32, Float64, Pinhole, RangeImage, RigidTransform

#: Half the edge of the cube around the nose tip that is looked at: the face's sphere, and a step.
_HALF_MM = 150.0
#: Pixels are pooled up to this width: half of the frontal grid's.
_PIXEL_MM = 1.4
#: A block of pixels whose depths differ by more lies on an edge.
_EDGE_MM = 20.0


def together(recent: Sequence[tuple[RangeImage, RigidTransform]], centre: Float64) -> RangeImage:
    """Surroundings of a nose tip, the mean of frames with their poses, as the first saw it."""
    first = recent[0][0]
    left, top, right, bottom = box(first, centre, _HALF_MM)
    factor = max(int(_PIXEL_MM / first.camera.pixel_mm(float(centre[2]))), 1)
    crops = [
        pooled(image.crop(left, top, right - left, bottom - top), factor) for image, _ in recent
    ]
    if len(crops) == 1:
        return crops[0]
    return motion_compensated_mean(crops, poses=[pose for _, pose in recent])


def pooled(image: RangeImage, factor: int) -> RangeImage:
    """Means of blocks of factor × factor pixels that are all valid and lie on one surface."""
    if factor == 1:
        return image
    rows, cols = (n // factor for n in image.shape)

    def blocks(plane: Float32) -> Float32:
        cut = plane[: rows * factor, : cols * factor].reshape(rows, factor, cols, factor)
        return np.ascontiguousarray(cut.transpose(1, 3, 0, 2)).reshape(-1, rows, cols)

    depth = blocks(image.depth)
    smooth = depth.max(axis=0) - depth.min(axis=0) < _EDGE_MM  # False where one is NaN
    camera = image.camera
    cx, cy = ((c - 0.5 * (factor - 1)) / factor for c in (camera.cx, camera.cy))
    smaller = (
        Pinhole(camera.fx / factor, camera.fy / factor, cx, cy, cols, rows)
        if isinstance(camera, Pinhole)
        else replace(camera, pitch_mm=camera.pitch_mm * factor, cx=cx, cy=cy, width=cols,
                     height=rows)
    )  # fmt: skip
    sigma = None
    if image.sigma is not None:
        sigma = np.sqrt((blocks(image.sigma) ** 2).mean(axis=0)) / np.float32(factor)
    amplitude = None if image.amplitude is None else blocks(image.amplitude).mean(axis=0)
    return RangeImage(
        np.where(smooth, depth.mean(axis=0), np.float32(np.nan)), smaller, sigma, amplitude
    )
