"""Cells are kept under what they depend on, whole or not at all, whoever computes them."""

import errno
import multiprocessing
import threading
import time

import numpy as np
import pytest

from rangeface.errors import ParameterError
from rangeface.evaluation import grid
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.experiments.stages import scans
from rangeface.evaluation.grid import cell, kept, key, run, waves
from rangeface.types import revision

PEOPLE = Source("synthetic", 2, 0, "", "any")
CALLS: list[int] = []


@kept
def number(store, *, value: int = 1):
    CALLS.append(value)
    return {"value": np.array(value)}


@kept
def total(store, *, of: tuple[grid.Cell, ...], scale: int = 1):
    return {"value": np.array(scale * sum(int(store.get(one)["value"]) for one in of))}


def large(store, *, value: int = 1):
    CALLS.append(value)
    return {"value": np.full(1000, value)}


@kept
def broken(store):
    raise ArithmeticError("half-way")


@pytest.fixture
def store(tmp_path):
    CALLS.clear()
    return grid.Store(tmp_path)


def files(folder):
    return {p.name: p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_a_key_depends_on_every_parameter_and_on_those_of_other_cells():
    inner = [cell(number, value=v) for v in (1, 2)]
    cells = [
        cell(total, of=(inner[0],)),
        cell(total, of=(inner[1],)),
        cell(total, of=tuple(inner)),
        cell(total, of=(inner[0],), scale=2),
        *inner,
    ]
    assert len({key(one) for one in cells}) == len(cells)
    assert key(cell(total, of=(inner[0],))) == key(cells[0])
    assert key(cell(number)) == key(cell(number, value=1))


def test_a_key_depends_on_the_revision():
    def method(store):
        return {}

    before = key(cell(method))
    key.cache_clear()
    revision(2)(method)
    assert key(cell(method)) != before


def test_a_result_is_computed_once(store):
    for _ in range(2):
        assert int(store.get(cell(number, value=7))["value"]) == 7
    assert CALLS == [7]


def test_a_damaged_file_is_computed_again(store):
    one = cell(number, value=7)
    store.get(one)
    whole = store.path(one).read_bytes()
    for damaged in (whole[:50], b"", b"no zip at all"):
        store.path(one).write_bytes(damaged)
        assert int(store.get(one)["value"]) == 7
        assert store.path(one).read_bytes() == whole


def test_a_full_disk_leaves_nothing_half_written(store, monkeypatch):
    def full(file, **arrays):
        file.write(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="No space left"):
        store.get(cell(number))
    assert files(store.folder) == {}


def test_shared_stages_come_before_those_who_need_them():
    inner = [cell(number, value=v) for v in (1, 2)]
    middle = cell(total, of=(inner[0],))
    outer = cell(total, of=(middle, inner[1]), scale=3)
    assert waves([outer]) == [[inner[0]], [middle, inner[1]], [outer]]
    assert waves([middle, middle]) == [[inner[0]], [middle]]


def test_a_run_that_broke_goes_on_and_ends_with_the_same_bytes(store, tmp_path):
    whole = [cell(number, value=v) for v in range(10)]
    with pytest.raises(ArithmeticError):
        run([*whole[:5], cell(broken)], store, grid.executor("serial"))
    assert list(range(5)) == CALLS
    seen = []
    run(whole, store, grid.executor("serial"), progress=lambda done, n: seen.append((done, n)))
    assert list(range(10)) == CALLS
    assert (seen[0], seen[-1]) == ((0, 5), (5, 5))
    fresh = grid.Store(tmp_path / "fresh")
    run(whole, fresh, grid.executor("serial"))
    assert files(fresh.folder).items() <= files(store.folder).items()


def test_what_is_too_large_to_keep_is_remembered(store):
    for _ in range(2):
        store.get(cell(large, value=3))
    assert CALLS == [3]
    for value in range(40):
        store.get(cell(large, value=value))
    assert files(store.folder) == {}
    assert len(store._memory) < 20


@pytest.mark.slow
def test_processes_give_the_bytes_of_one(tmp_path):
    cells = [cell(scans, source=PEOPLE, view=view) for view in ("frontal1", "laugh", "smile")]
    for name in ("serial", "processes"):
        run(cells, grid.Store(tmp_path / name), grid.executor(name))
    assert files(tmp_path / "serial") == files(tmp_path / "processes")
    assert len(files(tmp_path / "serial")) == 3


@pytest.mark.slow
def test_a_killed_worker_of_several_does_not_show(tmp_path):
    cells = [
        cell(scans, source=Source("synthetic", 2, seed, "", "any"), view=view)
        for seed in range(4)
        for view in ("frontal1", "laugh", "smile")
    ]
    run(cells, grid.Store(tmp_path / "serial"), grid.executor("serial"))

    def kill_when_something_is_done():
        while not list((tmp_path / "processes").rglob("*.npz")):
            time.sleep(0.02)
        multiprocessing.active_children()[0].kill()

    killer = threading.Thread(target=kill_when_something_is_done)
    killer.start()
    run(cells, grid.Store(tmp_path / "processes"), grid.executor("processes"))
    killer.join()
    # what the killed worker left half-written is no result
    kept = [
        {p.name: p.read_bytes() for p in (tmp_path / name).rglob("*.npz")}
        for name in ("serial", "processes")
    ]
    assert kept[0] == kept[1]


@pytest.mark.parametrize("name", ["threads", "dask", "dask:", ""])
def test_unknown_executors_are_refused(name):
    with pytest.raises(ParameterError, match="known: serial, processes, dask:ADDRESS"):
        grid.executor(name)
