"""(Face, Alignment, frontal image) → Assessment."""

from rangeface.assess._quality import quality

#: name → method: (Face, Alignment, RangeImage) → Assessment.
METHODS = {"quality": quality}

__all__ = ["METHODS", "quality"]
