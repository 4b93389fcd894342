"""Tables of the SQLite gallery, and how an older file becomes a newer one."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from rangeface.errors import GalleryError

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
)


def migrate(db: sqlite3.Connection, path: Path) -> None:
    """Bring the file to the newest version, in one transaction.

    Raises
    ------
    GalleryError
        The file comes from a newer rangeface.
    """
    version = db.execute("PRAGMA user_version").fetchone()[0]
    if version > len(MIGRATIONS):
        raise GalleryError(f"{path}: version {version} of a newer rangeface; update rangeface")
    if version == len(MIGRATIONS):
        return
    with db:
        db.execute("BEGIN IMMEDIATE")
        # another process may have migrated while this one waited for the lock
        version = db.execute("PRAGMA user_version").fetchone()[0]
        for statement in (s for step in MIGRATIONS[version:] for s in step):
            db.execute(statement)
        db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        db.execute(f"PRAGMA user_version = {len(MIGRATIONS)}")
