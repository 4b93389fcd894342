"""Image → faces: slice, connect, verify, crop; and follow a face from frame to frame."""

from rangeface.segment._follow import follow
from rangeface.segment._slices import slices

#: name → method: RangeImage → Faces.
METHODS = {"slices": slices}

__all__ = ["METHODS", "follow", "slices"]
