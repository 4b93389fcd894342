"""Face → Alignment: turn a face frontal, or refuse."""

from rangeface.register import frontal
from rangeface.register._icp import icp
from rangeface.register._none import none
from rangeface.register.bootstrap import bootstrap

#: name → method: Face → Alignment.
METHODS = {"icp": icp, "none": none}

#: name → resampling: (Face, Alignment) → frontal image.
FRONTAL = {"resample": frontal.resample}

__all__ = ["FRONTAL", "METHODS", "bootstrap", "frontal", "icp", "none"]
