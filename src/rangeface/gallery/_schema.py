"""Tables of the SQLite gallery, and how an older file becomes a newer one."""

from __future__ import annotations

from collections.abc import Mapping

from rangeface.errors import GalleryError
from rangeface.gallery._database import Database

APPLICATION_ID = 0x52464741  # "RFGA"

# One entry a version, never changed once released: a new file runs all of them.
MIGRATIONS = (
    (
        "CREATE TABLE meta (key TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT",
        "INSERT INTO meta VALUES ('seal', zeroblob(16))",
        """CREATE TABLE people (
            id INTEGER PRIMARY KEY AUTOINCREMENT,
            name TEXT NOT NULL UNIQUE,
            consent TEXT,
            expires TEXT,
            digest BLOB NOT NULL
        ) STRICT""",
        """CREATE TABLE templates (
            id INTEGER PRIMARY KEY AUTOINCREMENT,
            person INTEGER NOT NULL REFERENCES people (id),
            payload BLOB NOT NULL,
            digest BLOB NOT NULL
        ) STRICT""",
        "CREATE INDEX templates_of ON templates (person)",
    ),
    (
        """CREATE TABLE audit (
            id INTEGER PRIMARY KEY AUTOINCREMENT,
            at TEXT NOT NULL,
            action TEXT NOT NULL,
            person INTEGER NOT NULL,
            digest BLOB NOT NULL
        ) STRICT""",
        "INSERT INTO meta VALUES ('last audit line', x'')",
    ),
    (
        "ALTER TABLE people ADD COLUMN sealed BLOB",
        """CREATE TABLE images (
            template INTEGER PRIMARY KEY REFERENCES templates (id),
            payload BLOB NOT NULL,
            digest BLOB NOT NULL
        ) STRICT""",
    ),
)


def migrate(db: Database, meta: Mapping[str, bytes]) -> None:
    """Bring the file to the newest version, in one transaction.

    Parameters
    ----------
    db : Database
        A gallery of any version, or an empty file.
    meta : mapping
        What else a new gallery is born with.

    Raises
    ------
    GalleryError
        The file is no gallery, or comes from a newer rangeface.
    """
    with db.transaction():
        version = _version(db)
    if version == len(MIGRATIONS):
        return
    with db.transaction(write=True):
        version = _version(db)  # another process may have been faster
        for statement in (s for step in MIGRATIONS[version:] for s in step):
            db.run(statement)
        if version == 0:
            for key, value in meta.items():
                db.run("INSERT INTO meta VALUES (?, ?)", key, value)
        db.run(f"PRAGMA application_id = {APPLICATION_ID}")
        db.run(f"PRAGMA user_version = {len(MIGRATIONS)}")


def _version(db: Database) -> int:
    (tables,) = db.one("SELECT count(*) FROM sqlite_master")
    if tables and db.one("PRAGMA application_id")[0] != APPLICATION_ID:
        raise GalleryError(f"{db.path}: is an SQLite file, but no gallery")
    version = int(db.one("PRAGMA user_version")[0])
    if version > len(MIGRATIONS):
        raise GalleryError(f"{db.path}: version {version} of a newer rangeface; update rangeface")
    return version
