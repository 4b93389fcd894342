"""rangeface: recognises faces in noisy, low-resolution range images.

The way of a face::

    simulate → denoise → segment → register → assess → describe → classify → decide

Each verb is a subpackage. Units inside: mm, rad, s, sensor counts; depth is float32 (H, W)
with NaN where nothing was measured; the camera looks along +z, x right, y down.

Examples
--------
>>> import rangeface as rf
>>> camera = rf.Pinhole(fx=240, fy=240, cx=87.5, cy=71.5, width=176, height=144)
>>> camera.pixel_mm(400.0)
1.6666666666666667
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rangeface.errors import RangeFaceError as RangeFaceError
    from rangeface.types import Decision as Decision
    from rangeface.types import Pinhole as Pinhole
    from rangeface.types import RangeImage as RangeImage

__version__ = "0.1.0"

_HOME = {
    "RangeFaceError": "errors",
    "RangeImage": "types",
    "Pinhole": "types",
    "Decision": "types",
}

__all__ = ["Decision", "Pinhole", "RangeFaceError", "RangeImage"]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
