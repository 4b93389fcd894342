"""A user's folder → list of Scan, with the database's published protocols."""

from rangeface.datasets import _biwi, _bosphorus, _frgc, _gavab, _lock3dface, _own, _rap3df
from rangeface.datasets._biwi import biwi
from rangeface.datasets._bosphorus import bosphorus
from rangeface.datasets._folder import Database
from rangeface.datasets._frgc import frgc
from rangeface.datasets._gavab import gavab
from rangeface.datasets._lock3dface import lock3dface
from rangeface.datasets._own import folder
from rangeface.datasets._rap3df import rap3df

#: Every database that is supported, with its layout and its protocols.
DATABASES = {
    "gavab": Database(
        "GavabDB: 61 people × 9 laser scans",
        _gavab.LAYOUT,
        gavab,
        {"paper": _gavab.paper, "common": _gavab.common},
        _gavab.missing,
    ),
    "bosphorus": Database(
        "Bosphorus: 105 people, 4666 scans with expressions, poses, occlusions",
        _bosphorus.LAYOUT,
        bosphorus,
        {"first-neutral": _bosphorus.first_neutral},
        _bosphorus.missing,
    ),
    "frgc": Database(
        "FRGC v2: 466 people, 4007 laser scans",
        _frgc.LAYOUT,
        frgc,
        {"first-scan": _frgc.first_scan, "later-sessions": _frgc.later_sessions},
        _frgc.missing,
    ),
    "lock3dface": Database(
        "Lock3DFace: 509 people, Kinect v2 videos",
        _lock3dface.LAYOUT,
        lock3dface,
        {"first-neutral": _lock3dface.first_neutral},
        _lock3dface.missing,
    ),
    "biwi": Database(
        "Biwi Kinect head pose: 24 sequences",
        _biwi.LAYOUT,
        biwi,
        {"frontal-gallery": _biwi.frontal_gallery},
        _biwi.missing,
    ),
    "rap3df": Database(
        "RAP3DF 2017: 62 people, 267 Kinect v2 time-of-flight captures",
        _rap3df.LAYOUT,
        rap3df,
        {"gallery-tests": _rap3df.gallery_tests},
        _rap3df.missing,
    ),
    "folder": Database(
        "Your own: a folder with index.csv",
        _own.LAYOUT,
        folder,
        {"roles": list},
        _own.missing,
    ),
}

__all__ = [
    "DATABASES",
    "Database",
    "biwi",
    "bosphorus",
    "folder",
    "frgc",
    "gavab",
    "lock3dface",
    "rap3df",
]
