"""Scan files in, scan files out: one file a format; units are stated here and nowhere else."""

from rangeface.io._cloud import unit_mm
from rangeface.io._convert import convert_scan
from rangeface.io._describe import Description, describe_scan
from rangeface.io._formats import FORMATS, Format
from rangeface.io._read import read_frames, read_points, read_scan
from rangeface.io._source import Limits
from rangeface.io._write import WRITERS, write_frames, write_points, write_scan
from rangeface.io.biwi import read_pose
from rangeface.io.bosphorus import read_landmarks
from rangeface.io.camera_toml import CameraFile, read_camera
from rangeface.io.mcap import read_recording

__all__ = [
    "FORMATS",
    "WRITERS",
    "CameraFile",
    "Description",
    "Format",
    "Limits",
    "convert_scan",
    "describe_scan",
    "read_camera",
    "read_frames",
    "read_landmarks",
    "read_points",
    "read_pose",
    "read_recording",
    "read_scan",
    "unit_mm",
    "write_frames",
    "write_points",
    "write_scan",
]
