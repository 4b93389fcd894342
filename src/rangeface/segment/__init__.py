"""Image → faces: slice, connect, verify, crop; follow a face; and what a face consists of."""

from rangeface.segment._crop import sphere
from rangeface.segment._follow import follow
from rangeface.segment._landmarks import landmarks
from rangeface.segment._rectangle import rectangle
from rangeface.segment._slices import slices

#: name → method: RangeImage → Faces.
METHODS = {"slices": slices}

__all__ = ["METHODS", "follow", "landmarks", "rectangle", "slices", "sphere"]
