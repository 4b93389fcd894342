"""Scan files in, scan files out: one file a format; units are stated here and nowhere else."""

from rangeface.io._cloud import unit_mm
from rangeface.io._formats import FORMATS, Format
from rangeface.io._read import read_points, read_scan
from rangeface.io._source import Limits
from rangeface.io.camera_toml import CameraFile, read_camera

__all__ = [
    "FORMATS",
    "CameraFile",
    "Format",
    "Limits",
    "read_camera",
    "read_points",
    "read_scan",
    "unit_mm",
]
