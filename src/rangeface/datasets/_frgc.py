r"""FRGC v2: laser scans, ``.abs`` or ``.abs.gz``.

Layout: ``<subject>d<number>.abs[.gz]``, in the folders of the distribution (``Spring2003range``
is the training partition of FRGC, ``Fall2003range`` and ``Spring2004range`` the validation
partition of v2) or any other.

References
----------
P. J. Phillips et al., Overview of the Face Recognition Grand Challenge, CVPR 2005,
doi:10.1109/CVPR.2005.268.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rangeface.datasets._folder import by_subject, counted, first_against_rest, found, matching
from rangeface.datasets._folder import scan as make
from rangeface.types import Scan

LAYOUT = "<subject>d<number>.abs or .abs.gz, in Spring2003range, Fall2003range, Spring2004range"


def frgc(path: str | Path) -> list[Scan]:
    """List the scans of FRGC v2.

    Parameters
    ----------
    path : str or Path
        The folder; files may lie in folders below it.

    Returns
    -------
    list of Scan
        By subject and number; `session` is the folder's name, `role` is train in the training
        partition.

    Raises
    ------
    ScanError
        The folder does not exist or holds no such file.
    """
    files = [
        (match[1], int(match[2]), file)
        for file, match in matching(path, r"(\w+?)d(\d+)\.abs(?:\.gz)?")
    ]
    scans = [
        make(
            file,
            subject=subject,
            session=file.parent.name,
            role="train" if file.parent.name.lower() == "spring2003range" else "",
            view="frontal",
            sensor="Minolta Vivid 900/910",
        )
        for subject, _, file in sorted(files)
    ]
    return found(path, scans, LAYOUT)


def first_scan(scans: list[Scan]) -> list[Scan]:
    """Enrol each person's first scan of the validation partition, test all later ones.

    Parameters
    ----------
    scans : list of Scan
        As `frgc` lists them.

    Returns
    -------
    list of Scan
        The training partition keeps the role train.
    """
    training = [s for s in scans if s.role == "train"]
    return training + first_against_rest([s for s in scans if s.role != "train"], lambda s: True)


def later_sessions(scans: list[Scan]) -> list[Scan]:
    """Enrol the scans of Fall 2003, test those of Spring 2004: time between them (ROC III).

    Parameters
    ----------
    scans : list of Scan
        As `frgc` lists them, in the folders of the distribution.

    Returns
    -------
    list of Scan
        The training partition keeps the role train.
    """
    roles = {"spring2003range": "train", "fall2003range": "gallery", "spring2004range": "probe"}
    return [replace(s, role=roles[s.session.lower()]) for s in scans if s.session.lower() in roles]


def missing(scans: list[Scan]) -> list[str]:
    """How many scans and people of the two partitions are not there."""
    training = [s for s in scans if s.role == "train"]
    validation = [s for s in scans if s.role != "train"]
    return [
        *counted(len(training), 943, "training scans"),
        *counted(len(validation), 4007, "validation scans"),
        *counted(len(by_subject(validation)), 466, "people of the validation partition"),
    ]
