"""Who computes the cells: this process, several, or a Dask cluster. All give the same bytes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Protocol, TypeAlias

from rangeface.errors import ParameterError
from rangeface.evaluation.grid._store import Cell, Store

Progress: TypeAlias = Callable[[int, int], None]
Tasks: TypeAlias = Sequence[Sequence[Cell]]

#: A task whose worker dies is started again, so often.
_RETRIES = 5


class Executor(Protocol):
    """Computes tasks; yields how many cells each finished task held."""

    @property
    def workers(self) -> int:
        """Number of processes."""

    def __call__(self, store: Store, tasks: Tasks) -> Iterator[int]:
        """Compute the cells of all tasks into the store."""


def compute(store: Store, task: Sequence[Cell]) -> int:
    """Compute a task's cells one after the other, with one thread."""
    from threadpoolctl import threadpool_limits

    # sums in another order round differently: the number of threads must not show
    with threadpool_limits(1):
        for cell in task:
            if not store.path(cell).is_file():
                store.write(cell, cell(store))
    return len(task)


@dataclass(frozen=True)
class Serial:
    """Computes in the calling process."""

    workers: int = 1

    def __call__(self, store: Store, tasks: Tasks) -> Iterator[int]:
        """Compute the cells of all tasks into the store."""
        return (compute(store, task) for task in tasks)


@dataclass(frozen=True)
class Processes:
    """Computes in as many processes as there are cores."""

    workers: int

    def __call__(self, store: Store, tasks: Tasks) -> Iterator[int]:
        """Compute the cells of all tasks into the store."""
        left = list(tasks)
        for attempt in range(_RETRIES + 1):
            try:
                # a fork may copy locks that threads hold
                with ProcessPoolExecutor(self.workers, mp_context=get_context("spawn")) as pool:
                    yield from self._finish(pool, store, left)
            except BrokenProcessPool as broken:
                # somebody killed a worker, which takes its pool with it
                if attempt == _RETRIES:
                    raise OSError(
                        0, "workers die again and again; is there enough memory?", "executor"
                    ) from broken
            else:
                return

    def _finish(
        self, pool: ProcessPoolExecutor, store: Store, left: list[Sequence[Cell]]
    ) -> Iterator[int]:
        futures = {pool.submit(compute, store, task): task for task in left}
        try:
            for future in as_completed(futures):
                done = future.result()
                left.remove(futures[future])
                yield done
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


@dataclass(frozen=True)
class Dask:
    """Computes on a Dask cluster that sees the store's folder under the same path."""

    address: str
    workers: int

    def __call__(self, store: Store, tasks: Tasks) -> Iterator[int]:
        """Compute the cells of all tasks into the store."""
        from distributed import Client
        from distributed import as_completed as finished

        if not tasks:
            return
        with Client(self.address, timeout="10s") as client:
            futures = [
                client.submit(compute, store, task, pure=False, retries=_RETRIES) for task in tasks
            ]
            for future in finished(futures):
                yield future.result()


def executor(name: str) -> Executor:
    """The executor of a name.

    Parameters
    ----------
    name : str
        "serial", "processes", or "dask:ADDRESS", for instance "dask:tcp://10.0.0.5:8786".

    Returns
    -------
    Executor

    Raises
    ------
    ParameterError
        Unknown, no scheduler answers, or the extra `dask` is not installed.

    Examples
    --------
    >>> executor("serial").workers
    1
    """
    if name == "serial":
        return Serial()
    if name == "processes":
        return Processes(len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 2)
    kind, _, address = name.partition(":")
    if kind == "dask" and address:
        return Dask(address, _cluster_size(address))
    raise ParameterError(f"executor: unknown {name!r}; known: serial, processes, dask:ADDRESS")


def _cluster_size(address: str) -> int:
    try:
        from distributed import Client
    except ImportError as error:
        raise ParameterError(
            "executor: dask needs the extra: pip install 'rangeface[dask]'"
        ) from error
    try:
        with Client(address, timeout="10s") as client:
            return max(1, len(client.scheduler_info()["workers"]))
    except (OSError, ValueError) as error:
        raise ParameterError(f"executor: no Dask scheduler answers at {address}") from error
