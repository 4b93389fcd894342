"""VAP RGB-D face ``.dat``: 480 lines of 640 whole numbers, mm, negative where invalid.

The database states no intrinsics: a nominal Kinect (f = 575.8 px) stands in unless the caller
or a camera file says otherwise.
"""

from __future__ import annotations

from rangeface.errors import ScanFault
from rangeface.io._source import Source
from rangeface.io.camera_toml import depth_image
from rangeface.numerics.lines import first_line
from rangeface.numerics.text import numbers
from rangeface.types import Pinhole, RangeImage

WIDTH, HEIGHT = 640, 480
CAMERA = Pinhole(fx=575.8, fy=575.8, cx=319.5, cy=239.5, width=WIDTH, height=HEIGHT)


def recognise(source: Source) -> bool:
    """640 numbers on the first line, or the whole image on it."""
    if b"\0" in source.data[:1024]:
        return False
    first, _ = first_line(source.array[: 1 << 16], 0, WIDTH + 1)
    return len(first) == WIDTH or (len(first) > WIDTH and len(source.data) > 2 * WIDTH * HEIGHT - 2)


def parse(source: Source) -> RangeImage:
    """Depth image."""
    source.need(0, 2 * WIDTH * HEIGHT - 1, f"{WIDTH} × {HEIGHT} numbers")
    values, _ = numbers(source.array, 0, WIDTH * HEIGHT, commas=True)
    if len(values) < WIDTH * HEIGHT:
        raise source.error(
            ScanFault.TRUNCATED, f"{len(values)} of {WIDTH} × {HEIGHT} numbers can be read"
        )
    depth = values.reshape(HEIGHT, WIDTH)
    known = source.sibling([source.path.stem + ".toml", "camera.toml"]) is not None
    return depth_image(source, depth, unit="mm", camera=None if known else CAMERA)
