"""Face → Alignment: turn a face frontal, or refuse."""

from rangeface.register import frontal
from rangeface.register._icp import icp
from rangeface.register._none import none

#: name → method: Face → Alignment.
METHODS = {"icp": icp, "none": none}

__all__ = ["METHODS", "frontal", "icp", "none"]
