r"""Lock3DFace: Kinect v2 videos of 509 people.

Layout, as the authors' public sample shows it: ``<NNN>_Kinect_<kind>_<n>DEPTH/<frame>.png`` in
any folder, 16-bit depth in mm. Kinds: NU neutral, FE expression, PS pose, OC occlusion, TM
another time. A ``camera.toml`` in or above the folder states the camera; without one a
512 × 424 image is taken to be a nominal Kinect v2's.

References
----------
J. Zhang, D. Huang, Y. Wang, J. Sun, Lock3DFace: a large-scale database of low-cost Kinect 3D
faces, ICB 2016, doi:10.1109/ICB.2016.7550062. G. Mu et al., Led3D, CVPR 2019,
doi:10.1109/CVPR.2019.00592 (protocol).
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

from rangeface.datasets._folder import by_subject, counted, first_against_rest, found
from rangeface.errors import ScanError, ScanFault
from rangeface.io import read_scan
from rangeface.types import Pinhole, RangeImage, Scan

LAYOUT = "<NNN>_Kinect_{NU,FE,PS,OC,TM}_<n>DEPTH/<frame>.png"

KINECT_V2 = Pinhole(fx=365.5, fy=365.5, cx=256.0, cy=206.0, width=512, height=424)

_VIDEO = re.compile(r"(\d{3})_kinect_([a-z]{2})_(\d+)depth", re.IGNORECASE)


def lock3dface(path: str | Path, *, frame: int = 0) -> list[Scan]:
    """List the videos of Lock3DFace, one frame of each.

    Parameters
    ----------
    path : str or Path
        The folder; videos may lie in folders below it.
    frame : int
        Which frame a scan loads, ≥ 0; the last one where the video is shorter.

    Returns
    -------
    list of Scan
        `path` is the video's folder, `session` its kind and number, `view` its kind.

    Raises
    ------
    ScanError
        The folder does not exist or holds no such video.
    """
    root = Path(path)
    scans = []
    for folder in sorted(root.rglob("*")) if root.is_dir() else ():
        match = _VIDEO.fullmatch(folder.name)
        if match is None or not folder.is_dir():
            continue
        kind = match[2].upper()
        scans.append(
            Scan(
                folder,
                partial(_load, frame),
                subject=match[1],
                session=f"{kind}_{match[3]}",
                view="turned" if kind == "PS" else "frontal",
                expression="neutral" if kind == "NU" else "varied" if kind == "FE" else "",
                sensor="Kinect v2",
            )
        )
    return found(path, scans, LAYOUT)


def _load(frame: int, folder: Path) -> RangeImage:
    images = sorted(folder.glob("*.png"))
    if not images:
        raise ScanError(folder, ScanFault.MISSING, "no PNG in the video's folder")
    file = images[min(frame, len(images) - 1)]
    above = [file.parent, *list(file.parents)[1:4]]
    if any((place / "camera.toml").is_file() for place in above):
        return read_scan(file)
    return read_scan(file, camera=KINECT_V2, unit="mm")


def first_neutral(scans: list[Scan]) -> list[Scan]:
    """Enrol each person's first neutral video, test all others; report by kind.

    Parameters
    ----------
    scans : list of Scan
        As `lock3dface` lists them.

    Returns
    -------
    list of Scan
        People without a neutral video are left out.
    """
    order = sorted(scans, key=lambda s: (s.subject, not s.session.startswith("NU"), s.session))
    return first_against_rest(order, lambda s: s.session.startswith("NU"))


def missing(scans: list[Scan]) -> list[str]:
    """How many people are not there, and who has no neutral video."""
    people = by_subject(scans)
    lines = counted(len(people), 509, "people")
    bare = [n for n, own in people.items() if not any(s.session.startswith("NU") for s in own)]
    return lines + [f"{name}: no neutral video" for name in bare]
