r"""Bosphorus: structured-light scans of 105 people with expressions, poses and occlusions.

Layout, flat or in a folder a person: ``bs<000-104>_<group>_<code>_<n>.bnt``, landmarks beside
it in ``.lm3``. Groups: N neutral, E emotion, LFAU / UFAU / CAU action units, YR, PR and CR
rotations, O occlusion, IGN.

References
----------
A. Savran et al., Bosphorus database for 3D face analysis, BioID 2008, LNCS 5372,
doi:10.1007/978-3-540-89991-4_6.
"""

from __future__ import annotations

from pathlib import Path

from rangeface.datasets._folder import by_subject, counted, first_against_rest, found, matching
from rangeface.datasets._folder import scan as make
from rangeface.io import read_landmarks
from rangeface.types import Scan

LAYOUT = "bs<000-104>_{N,E,LFAU,UFAU,CAU,YR,PR,CR,O,IGN}_<code>_<n>.bnt, .lm3 beside it"

_TURNED = ("YR", "PR", "CR")
_EXPRESSIVE = ("E", "LFAU", "UFAU", "CAU")


def bosphorus(path: str | Path, *, landmarks: bool = True) -> list[Scan]:
    """List the scans of the Bosphorus database.

    Parameters
    ----------
    path : str or Path
        The folder; files may lie in folders below it.
    landmarks : bool
        Read the ``.lm3`` file beside each scan that has one.

    Returns
    -------
    list of Scan
        `view` is frontal or the code of the rotation; `expression` is neutral, the code of the
        expression, or "" ; `session` is group, code and number; occlusions keep their code
        there.

    Raises
    ------
    ScanError
        The folder does not exist or holds no such file, or a landmark file is broken.
    """
    scans = []
    for file, match in matching(path, r"bs(\d{3})_([a-z]+)_(.+)_(\d+)\.bnt"):
        group, code = match[2].upper(), match[3]
        marks = file.with_suffix(".lm3")
        scans.append(
            make(
                file,
                subject=f"bs{match[1]}",
                session=f"{group}_{code}_{match[4]}",
                view=f"{group}_{code}" if group in _TURNED else "frontal",
                expression="neutral" if group == "N" else code if group in _EXPRESSIVE else "",
                sensor="Inspeck Mega Capturor II",
                landmarks=read_landmarks(marks) if landmarks and marks.is_file() else {},
            )
        )
    return found(path, scans, LAYOUT)


def first_neutral(scans: list[Scan]) -> list[Scan]:
    """Enrol each person's first neutral scan, test all others.

    Parameters
    ----------
    scans : list of Scan
        As `bosphorus` lists them.

    Returns
    -------
    list of Scan
        People without a neutral scan are left out.
    """
    return first_against_rest(scans, lambda s: s.session.startswith("N_N_"))


def missing(scans: list[Scan]) -> list[str]:
    """Which people have no scan or no neutral one, and how many scans are not there."""
    people = by_subject(scans)
    lines = counted(len(scans), 4666, "scans")
    for name in (f"bs{number:03d}" for number in range(105)):
        if name not in people:
            lines.append(f"{name}: all")
        elif not any(s.session.startswith("N_N_") for s in people[name]):
            lines.append(f"{name}: no neutral scan")
    return lines
