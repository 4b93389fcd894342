"""Makes scans: heads of people who do not exist, and cameras that see them as real ones would."""

from rangeface.simulate._anatomy import Tissue
from rangeface.simulate._capture import METHODS, capture, frames, random_point, triangulate
from rangeface.simulate._collection import VIEWS, Labelled, View, collection
from rangeface.simulate._degrade import (
    add_noise,
    add_noise_psnr,
    coarsen,
    degrade,
    punch_holes,
    quantise,
)
from rangeface.simulate._gesture import EXPRESSIONS
from rangeface.simulate._head import Head, head, mean_head
from rangeface.simulate._morphable import MorphableModel, ict_facekit
from rangeface.simulate._scene import Scene, pose, render
from rangeface.simulate._sequence import Frame, Motion, sequence
from rangeface.simulate._shapes import ball, wall
from rangeface.simulate._things import cushion, hand, shoulders
from rangeface.simulate._tof import Buckets, amplitude, buckets, decode, tof

__all__ = [
    "EXPRESSIONS",
    "METHODS",
    "VIEWS",
    "Buckets",
    "Frame",
    "Head",
    "Labelled",
    "MorphableModel",
    "Motion",
    "Scene",
    "Tissue",
    "View",
    "add_noise",
    "add_noise_psnr",
    "amplitude",
    "ball",
    "buckets",
    "capture",
    "coarsen",
    "collection",
    "cushion",
    "decode",
    "degrade",
    "frames",
    "hand",
    "head",
    "ict_facekit",
    "mean_head",
    "pose",
    "punch_holes",
    "quantise",
    "random_point",
    "render",
    "sequence",
    "shoulders",
    "tof",
    "triangulate",
    "wall",
]
