"""Image → faces: slice, connect, verify, crop."""

from rangeface.segment._slices import slices

#: name → method: RangeImage → Faces.
METHODS = {"slices": slices}

__all__ = ["METHODS", "slices"]
