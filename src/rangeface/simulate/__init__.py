"""Makes scans: heads of people who do not exist, and cameras that see them as real ones would."""

from rangeface.simulate._anatomy import Tissue
from rangeface.simulate._head import Head, head, mean_head
from rangeface.simulate._scene import Scene, pose, render
from rangeface.simulate._tof import Buckets, amplitude, buckets, decode, tof

__all__ = [
    "Buckets",
    "Head",
    "Scene",
    "Tissue",
    "amplitude",
    "buckets",
    "decode",
    "head",
    "mean_head",
    "pose",
    "render",
    "tof",
]
