r"""Biwi Kinect head pose: 24 sequences of 20 people who turn their heads.

Layout: ``<01-24>/frame_<NNNNN>_depth.bin`` with ``frame_<NNNNN>_pose.txt`` or ``_pose.bin`` and
one ``depth.cal`` a folder. Four people were recorded twice; the files do not say who, so a
subject here is a sequence.

References
----------
G. Fanelli et al., Random forests for real time 3D face analysis, IJCV 101, 2013,
doi:10.1007/s11263-012-0549-0.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from rangeface.datasets._folder import by_subject, counted, found, matching
from rangeface.datasets._folder import scan as make
from rangeface.io import read_pose
from rangeface.types import Scan

LAYOUT = "<01-24>/frame_<NNNNN>_depth.bin, frame_<NNNNN>_pose.txt or .bin, depth.cal"

_SEQUENCES = 24


def biwi(path: str | Path) -> list[Scan]:
    """List the frames of the Biwi head pose database.

    Parameters
    ----------
    path : str or Path
        The folder that holds the sequences.

    Returns
    -------
    list of Scan
        `session` is the frame's number; `view` is "yaw pitch roll" in whole degrees as the pose
        file's rotation gives them, "" without one; landmark ``head`` is the point it states.

    Raises
    ------
    ScanError
        The folder does not exist or holds no such file, or a pose file is broken.
    """
    scans = []
    for file, match in matching(path, r"frame_(\d+)_depth\.bin"):
        stem = file.name.removesuffix("_depth.bin")
        poses = [file.with_name(stem + end) for end in ("_pose.txt", "_pose.bin")]
        pose = next((read_pose(p) for p in poses if p.is_file()), None)
        scans.append(
            make(
                file,
                subject=file.parent.name,
                session=match[1],
                view="" if pose is None else _degrees(pose.rotation),
                landmarks={} if pose is None else {"head": pose.translation},
                sensor="Kinect v1",
            )
        )
    return found(path, scans, LAYOUT)


def _degrees(rotation: np.ndarray) -> str:
    """Yaw, pitch and roll of R = R_z R_y R_x, degrees."""
    pitch = np.arctan2(rotation[2, 1], rotation[2, 2])
    yaw = np.arcsin(np.clip(-rotation[2, 0], -1, 1))
    roll = np.arctan2(rotation[1, 0], rotation[0, 0])
    return " ".join(f"{a:.0f}" for a in np.rad2deg([yaw, pitch, roll]) + 0.0)


def frontal_gallery(scans: list[Scan]) -> list[Scan]:
    """Enrol each sequence's most frontal frame, test all others: ours, none is published.

    Parameters
    ----------
    scans : list of Scan
        As `biwi` lists them.

    Returns
    -------
    list of Scan
        Frames without a pose are left out.
    """
    out = []
    for own in by_subject([s for s in scans if s.view]).values():
        best = min(own, key=lambda s: sum(float(a) ** 2 for a in s.view.split()))
        out += [replace(s, role="gallery" if s is best else "probe") for s in own]
    return out


def missing(scans: list[Scan]) -> list[str]:
    """Which sequences are not there, and how many frames have no pose."""
    people = by_subject(scans)
    lines = [f"{n:02d}: all" for n in range(1, _SEQUENCES + 1) if f"{n:02d}" not in people]
    return lines + counted(sum(bool(s.view) for s in scans), len(scans), "frames with a pose")
