"""The table of formats: how each is recognised and read, and what it means by a number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rangeface.errors import ScanFault
from rangeface.io import (
    biwi,
    bosphorus,
    frgc,
    mcap,
    npz,
    obj,
    off,
    pcd,
    ply,
    png16,
    rap3df,
    stl,
    swissranger,
    tiff,
    vap,
    vrml,
    xyz,
)
from rangeface.io._cloud import Cloud
from rangeface.io._source import Source
from rangeface.types import RangeImage


@dataclass(frozen=True)
class Format:
    """One file format.

    Parameters
    ----------
    title : str
        What it is, for a person.
    recognise : callable
        Whether a source is of this format, by its content.
    parse : callable
        Reads a source: a depth image, or points in the file's unit and axes.
    unit : str, optional
        Unit of the points, where the format or its users' convention has one.
    front, up : str
        The file's axes towards the viewer and the top of the head.
    """

    title: str
    recognise: Callable[[Source], bool]
    parse: Callable[[Source], RangeImage | Cloud]
    unit: str | None = "mm"
    front: str = "+z"
    up: str = "+y"


#: In the order in which they are tried: signatures first, what only a whole file shows last.
FORMATS = {
    "png": Format(
        "16-bit greyscale PNG with a camera TOML, or TrueDepth's JSON",
        png16.recognise,
        png16.parse,
        None,
    ),
    "tiff": Format("16- or 32-bit TIFF with a camera TOML", tiff.recognise, tiff.parse, None),
    "npz": Format("NumPy archive with arrays depth and camera", npz.recognise, npz.parse),
    "mcap": Format("MCAP recording of ROS depth images", mcap.recognise, mcap.parse, None),
    "vrml": Format("VRML 1.0 or 2.0 scene (GavabDB, BU-3DFE, …)", vrml.recognise, vrml.parse),
    "ply": Format("PLY points, mesh or range grid", ply.recognise, ply.parse),
    "pcd": Format("PCD cloud of PCL and ROS", pcd.recognise, pcd.parse, "m", "-z", "-y"),
    "off": Format("OFF mesh", off.recognise, off.parse),
    "frgc": Format("FRGC .abs grid", frgc.recognise, frgc.parse),
    "obj": Format("Wavefront OBJ points or mesh", obj.recognise, obj.parse),
    "stl": Format("STL mesh", stl.recognise, stl.parse),
    "rap3df": Format("RAP3DF .data (Kinect v2)", rap3df.recognise, rap3df.parse),
    "bosphorus": Format("Bosphorus .bnt grid", bosphorus.recognise, bosphorus.parse),
    "biwi": Format("Biwi .bin depth image", biwi.recognise, biwi.parse, "mm"),
    "swissranger": Format("SwissRanger .dat log", swissranger.recognise, swissranger.parse, "m"),
    "vap": Format("VAP .dat depth image", vap.recognise, vap.parse, "mm"),
    "xyz": Format("Points as text, one a line", xyz.recognise, xyz.parse),
}


#: Those that hold points or meshes; the others hold depth images.
POINT_FORMATS = ("vrml", "ply", "pcd", "off", "frgc", "obj", "stl", "bosphorus", "xyz")


def identify(source: Source) -> str:
    """Name of the format of a source, found by its content."""
    for name, entry in FORMATS.items():
        if entry.recognise(source):
            return name
    raise source.error(
        ScanFault.UNKNOWN_FORMAT, f"starts with {source.data[:8]!r}; known: {', '.join(FORMATS)}"
    )
