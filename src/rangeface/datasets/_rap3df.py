"""RAP3DF, first set (2017): Kinect v2 time-of-flight faces of 62 people.

Layout, as in the public repository Piemontez/rap3df-database (academic use only)::

    rap3df_data/<SUBJECT>/k1_box_xyz_depth.data          gallery: one frontal capture
    rap3df_data/<SUBJECT>/tests/<TEST>k1_box_xyz_depth.data   probes: other poses, expressions
    rap3df_data/<SUBJECT>/tests/database.csv             <TEST>;119;149;

Protocol: each person's gallery capture is enrolled, every test capture is a probe.
"""

from __future__ import annotations

from pathlib import Path

from rangeface.datasets._folder import by_subject, counted, found, scan
from rangeface.types import Scan

LAYOUT = "<SUBJECT>/k1_box_xyz_depth.data, <SUBJECT>/tests/*k1_box_xyz_depth.data"

_DEPTH = "k1_box_xyz_depth.data"


def rap3df(path: str | Path) -> list[Scan]:
    """List the captures of RAP3DF.

    Parameters
    ----------
    path : str or Path
        The folder ``rap3df_data``, or one that contains it.

    Returns
    -------
    list of Scan
        By subject, gallery before probes; `session` is the test's name.

    Raises
    ------
    ScanError
        The folder does not exist or holds no capture in this layout.
    """
    root = Path(path)
    inner = root / "rap3df_data"
    root = inner if inner.is_dir() else root
    scans = []
    for folder in sorted(root.iterdir()) if root.is_dir() else ():
        gallery = folder / _DEPTH
        if gallery.is_file():
            scans.append(_scan(gallery, folder.name, "gallery", ""))
        for probe in sorted((folder / "tests").glob("*" + _DEPTH)):
            scans.append(_scan(probe, folder.name, "probe", probe.name.removesuffix(_DEPTH)))
    return found(path, scans, LAYOUT)


def _scan(path: Path, subject: str, role: str, session: str) -> Scan:
    return scan(path, subject=subject, role=role, session=session, sensor="Kinect v2")


def gallery_tests(scans: list[Scan]) -> list[Scan]:
    """Enrol each person's gallery capture, test the others: the database's own division.

    Parameters
    ----------
    scans : list of Scan
        As `rap3df` lists them; their roles stand already.

    Returns
    -------
    list of Scan
        The same scans.
    """
    return list(scans)


def missing(scans: list[Scan]) -> list[str]:
    """How many captures are not there, and who has no gallery capture."""
    people = by_subject(scans)
    lines = counted(len(people), 62, "people") + counted(len(scans), 267, "captures")
    bare = [name for name, own in people.items() if not any(s.role == "gallery" for s in own)]
    return lines + [f"{name}: no gallery capture" for name in bare]
