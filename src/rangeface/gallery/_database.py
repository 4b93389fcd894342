"""The SQLite file of a gallery: how it is opened, and what a transaction promises."""

from __future__ import annotations

import random
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import RLock
from typing import Any

from rangeface.errors import GalleryError

# A rollback journal, not WAL: SQLite before 3.51.3 can lose acknowledged WAL commits (the reset
# bug), and a WAL file keeps what was deleted. EXTRA syncs the folder too, so that a journal which
# a power cut brings back cannot undo an acknowledged write. Deleted bytes are overwritten.
_PRAGMAS = (
    "journal_mode = DELETE",
    "synchronous = EXTRA",
    "secure_delete = ON",
    "foreign_keys = ON",
    "cell_size_check = ON",
    "trusted_schema = OFF",
)


class Database:
    """One connection, used by one thread at a time; every failure is a GalleryError.

    Parameters
    ----------
    path : Path
        The file.
    timeout_s : float
        How long to wait for another process's write, s.
    """

    def __init__(self, path: Path, timeout_s: float) -> None:
        self.path = path
        self._lock = RLock()
        self._undone = 0
        self._timeout_s = timeout_s
        with self._guard():
            self.connection = sqlite3.connect(
                path, timeout=timeout_s, isolation_level=None, check_same_thread=False
            )
        try:
            with self._guard():
                for pragma in _PRAGMAS:
                    self.connection.execute(f"PRAGMA {pragma}")
        except GalleryError:
            self.connection.close()
            raise

    def run(self, sql: str, *values: Any) -> int:
        """Execute a statement; gives the number of the row that it inserted, if it did."""
        return int(self.connection.execute(sql, values).lastrowid or 0)

    def find(self, sql: str, *values: Any) -> tuple[Any, ...] | None:
        """The first row, or None."""
        row: tuple[Any, ...] | None = self.connection.execute(sql, values).fetchone()
        return row

    def one(self, sql: str, *values: Any) -> tuple[Any, ...]:
        """The first row, which must be there in a sound file."""
        row = self.find(sql, *values)
        if row is None:
            raise self.damaged("a row is missing")
        return row

    def all(self, sql: str, *values: Any) -> list[tuple[Any, ...]]:
        """All rows."""
        return self.connection.execute(sql, values).fetchall()

    @property
    def version(self) -> tuple[int, int, int]:
        """Changes when the contents may: others' commits, own changes, own changes undone."""
        return (
            self.one("PRAGMA data_version")[0],
            self.connection.total_changes,
            self._undone,
        )

    @contextmanager
    def transaction(self, *, write: bool = False) -> Iterator[None]:
        """All or nothing, on one state of the file; a write is durable when this is left."""
        with self._lock, self._guard():
            self._begin(write)
            try:
                yield
                self.connection.execute("COMMIT")
            except BaseException:
                self._undone += 1
                if self.connection.in_transaction:
                    self.connection.execute("ROLLBACK")
                raise

    def _begin(self, write: bool) -> None:
        """Take the lock, asking often: SQLite's own waiting sleeps 100 ms and can starve."""
        deadline = time.monotonic() + self._timeout_s
        self.connection.execute("PRAGMA busy_timeout = 0")
        try:
            while not self._began(write, last=time.monotonic() > deadline):
                time.sleep(random.uniform(0.0005, 0.003))
        finally:
            self.connection.execute(f"PRAGMA busy_timeout = {int(1000 * self._timeout_s)}")

    def _began(self, write: bool, *, last: bool) -> bool:
        try:
            self.connection.execute("BEGIN IMMEDIATE" if write else "BEGIN")
            if not write:  # only now is the file locked for reading
                self.connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
        except sqlite3.OperationalError as error:
            if self.connection.in_transaction:
                self.connection.execute("ROLLBACK")
            if last or error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY:
                raise
            return False
        return True

    def copy_to(self, target: Path) -> None:
        """Replace the contents of another file by those of this one, in one transaction."""
        with self._lock, self._guard():
            copy = sqlite3.connect(target)
            try:
                for pragma in _PRAGMAS:
                    copy.execute(f"PRAGMA {pragma}")
                self.connection.backup(copy)
            finally:
                copy.close()

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self.connection.close()

    def damaged(self, detail: str) -> GalleryError:
        """The error for a file whose contents contradict each other."""
        return GalleryError(f"{self.path}: damaged ({detail}); restore a backup")

    @contextmanager
    def _guard(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise GalleryError(f"{self.path}: {error}") from error
        except UnicodeDecodeError as error:  # text that sqlite3 hands over is no longer text
            raise self.damaged(str(error)) from error
