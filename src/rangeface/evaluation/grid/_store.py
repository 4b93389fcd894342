"""Cells, their keys, and the folder that keeps their results."""

from __future__ import annotations

import os
import tempfile
import zipfile
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from rangeface.pipeline import Step, fingerprint, step

Arrays: TypeAlias = Mapping[str, NDArray[Any]]
Cell: TypeAlias = Step
F = TypeVar("F", bound=Callable[..., Arrays])

#: So many intermediate results stay in memory, for the cells that follow.
_REMEMBERED = 12


def cell(function: Callable[..., Arrays], /, **params: Any) -> Cell:
    """Bind a cell's function to its parameters; what is left out has its default.

    Parameters
    ----------
    function : callable
        ``f(store, *, …) -> {name: array}``, pure: the same parameters give the same arrays.
    **params
        Hashable values, steps, or other cells.

    Returns
    -------
    Cell

    Raises
    ------
    ParameterError
        The function has no such keyword parameter.
    """
    return step(function, **params)


def kept(function: F) -> F:
    """Mark a cell's function: its results are worth a file, what is unmarked only memory."""
    function.kept = True  # type: ignore[attr-defined]
    return function


def is_kept(cell: Cell) -> bool:
    """Whether the results of a cell are kept as files."""
    return getattr(cell.method, "kept", False)


@lru_cache(maxsize=65536)
def key(cell: Cell) -> str:
    """What a cell depends on, as 64 hex digits."""
    # an inner cell stands for itself by its key: hashed once, however many cells need it
    return fingerprint(Step(cell.method, tuple((n, _by_key(v)) for n, v in cell.params)))


def _by_key(value: Any) -> Any:
    if isinstance(value, Step):
        return f"step {key(value)}"
    return tuple(map(_by_key, value)) if type(value) is tuple else value


@dataclass(frozen=True)
class Store:
    """A folder of results, one file a kept cell; a file is whole or it is not there.

    Parameters
    ----------
    folder : Path
        Made when the first result is kept. Safe to share: several processes that compute one
        cell write the same bytes.
    """

    folder: Path
    _memory: OrderedDict[str, Arrays] = field(
        default_factory=OrderedDict, repr=False, compare=False
    )

    def __reduce__(self) -> tuple[type[Store], tuple[Path]]:
        return type(self), (self.folder,)  # what is in memory stays here

    def path(self, cell: Cell) -> Path:
        """Where the result of a cell is kept."""
        name = key(cell)
        return self.folder / name[:2] / f"{name}.npz"

    def get(self, cell: Cell) -> Arrays:
        """The result of a cell, computed if need be.

        The result of a `kept` function is in a file; any other is in memory only, for a while.
        """
        return self._kept(cell) if is_kept(cell) else self._remembered(cell)

    def _kept(self, cell: Cell) -> Arrays:
        arrays = self.read(cell)
        if arrays is None:
            arrays = cell(self)
            self.write(cell, arrays)
        return arrays

    def _remembered(self, cell: Cell) -> Arrays:
        name = key(cell)
        if name not in self._memory:
            self._memory[name] = cell(self)
        self._memory.move_to_end(name)
        while len(self._memory) > _REMEMBERED:
            self._memory.popitem(last=False)
        return self._memory[name]

    def read(self, cell: Cell) -> dict[str, NDArray[Any]] | None:
        """The kept result of a cell; None if there is none, or if its file is damaged."""
        try:
            with self.path(cell).open("rb") as file, np.load(file, allow_pickle=False) as arrays:
                return {name: arrays[name] for name in arrays.files}
        except FileNotFoundError:
            return None
        except (ValueError, EOFError, zipfile.BadZipFile):
            return None  # computed again and written anew

    def write(self, cell: Cell, arrays: Arrays) -> None:
        """Keep a result: written beside, then renamed.

        Raises
        ------
        OSError
            The disk is full or the folder cannot be written; nothing half-written stays.
        """
        path = self.path(cell)
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, suffix=".partial")
        try:
            with os.fdopen(handle, "wb") as file:
                np.savez(file, allow_pickle=False, **arrays)
            os.replace(name, path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
