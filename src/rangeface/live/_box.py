"""Where a face lies in the image."""

from __future__ import annotations

import numpy as np

from rangeface.types import Float64, Pinhole, RangeImage


def box(image: RangeImage, centre: Float64, radius_mm: float) -> tuple[int, int, int, int]:
    """Pixels (left, top, right, bottom) that a cube around a point covers, inside the image."""
    rows, cols = image.shape
    z = float(centre[2]) - radius_mm
    if isinstance(image.camera, Pinhole) and z < 1.0:
        return 0, 0, cols, rows
    corners = np.array(
        [[x, y, z] for x in (-radius_mm, radius_mm) for y in (-radius_mm, radius_mm)]
    )
    pixels = image.camera.project(corners + np.array([*centre[:2], 0.0]))
    low = np.clip(np.floor(pixels.min(axis=0)), 0, [cols - 1, rows - 1]).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)) + 1, low + 1, [cols, rows]).astype(int)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])
