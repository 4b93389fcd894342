r"""GavabDB: laser scans of 61 people, nine each, VRML 1.0.

Layout, flat or in folders: ``cara<1-61>_<take>.wrl`` with the takes frontal1, frontal2, arriba
(up), abajo (down), derecha (right), izquierda (left), gesto (random gesture), risa (laugh) and
sonrisa (smile).

References
----------
A. B. Moreno, A. Sánchez, GavabDB: a 3D face database, Proc. 2nd COST 275 Workshop on Biometrics
on the Internet, 2004.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from rangeface.datasets._folder import first_against_rest, found, matching, scan
from rangeface.types import Scan

LAYOUT = "cara<1-61>_{frontal1,frontal2,arriba,abajo,derecha,izquierda,gesto,risa,sonrisa}.wrl"

_TAKES = {
    "frontal1": ("frontal", "neutral"),
    "frontal2": ("frontal", "neutral"),
    "arriba": ("up", "neutral"),
    "abajo": ("down", "neutral"),
    "derecha": ("right", "neutral"),
    "izquierda": ("left", "neutral"),
    "gesto": ("frontal", "gesture"),
    "risa": ("frontal", "laugh"),
    "sonrisa": ("frontal", "smile"),
}
_PEOPLE = 61


def gavab(path: str | Path) -> list[Scan]:
    """List the scans of GavabDB.

    Parameters
    ----------
    path : str or Path
        The folder; files may lie in folders below it.

    Returns
    -------
    list of Scan
        `session` is the take as the file names it; `view` is frontal, up, down, right or left.

    Raises
    ------
    ScanError
        The folder does not exist or holds no such file.
    """
    takes = "|".join(_TAKES)
    scans = []
    for file, match in matching(path, rf"cara0*(\d{{1,2}})_({takes})\.wrl(?:\.gz)?"):
        take = match[2].lower()
        view, expression = _TAKES[take]
        facts: dict[str, Any] = {"session": take, "view": view, "expression": expression}
        scans.append(scan(file, subject=f"cara{match[1]}", sensor="Minolta VI-700", **facts))
    return found(path, scans, LAYOUT)


def paper(scans: list[Scan]) -> list[Scan]:
    """Enrol frontal 1 and the smile; test frontal 2 and the laugh: the paper's closed set.

    Parameters
    ----------
    scans : list of Scan
        As `gavab` lists them.

    Returns
    -------
    list of Scan
        Our reading of section 4 of Ebers et al., which says "frontal view images with neutral
        and non-neutral facial expressions".
    """
    roles = {"frontal1": "gallery", "sonrisa": "gallery", "frontal2": "probe", "risa": "probe"}
    return [replace(s, role=roles[s.session]) for s in scans if s.session in roles]


def common(scans: list[Scan]) -> list[Scan]:
    """Enrol frontal 1, test the other eight takes; report by view.

    Parameters
    ----------
    scans : list of Scan
        As `gavab` lists them.

    Returns
    -------
    list of Scan
        People without frontal 1 are left out.
    """
    return first_against_rest(scans, lambda s: s.session == "frontal1")


def missing(scans: list[Scan]) -> list[str]:
    """Which takes of which people are not there, one line a person."""
    have = {(s.subject, s.session) for s in scans}
    lines = []
    for number in range(1, _PEOPLE + 1):
        gone = [take for take in _TAKES if (f"cara{number}", take) not in have]
        if gone:
            lines.append(f"cara{number}: {'all' if len(gone) == len(_TAKES) else ', '.join(gone)}")
    return lines
