"""The things that the stages hand to each other.

Lengths are mm, angles rad, amplitude sensor counts. The camera frame is x right, y down,
z forward; the face frame has the same axes for a frontal face and its origin at the nose
tip. Pixel (column u, row v) has its centre at the integer coordinates (u, v). An invalid
pixel is NaN in depth. Arrays are read-only.
"""

from rangeface.types._arrays import Float32, Float64, Mask, revision
from rangeface.types._cameras import Camera, Orthographic, Pinhole
from rangeface.types._faces import Alignment, Assessment, Face, Faces, Reason, ReferenceFace
from rangeface.types._images import PointSet, RangeImage
from rangeface.types._people import Decision, Scan, Template, Verdict
from rangeface.types._poses import RigidTransform

__all__ = [
    "Alignment",
    "Assessment",
    "Camera",
    "Decision",
    "Face",
    "Faces",
    "Float32",
    "Float64",
    "Mask",
    "Orthographic",
    "Pinhole",
    "PointSet",
    "RangeImage",
    "Reason",
    "ReferenceFace",
    "RigidTransform",
    "Scan",
    "Template",
    "Verdict",
    "revision",
]
