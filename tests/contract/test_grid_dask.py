"""A Dask cluster gives the bytes of one process, also when a worker is killed in the middle."""

import os
import signal
import threading
import time

import pytest

from rangeface.errors import ParameterError
from rangeface.evaluation import grid
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.experiments.stages import scans
from rangeface.evaluation.grid import cell, run

distributed = pytest.importorskip("distributed", reason="needs the extra dask")

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("default")]


def test_a_killed_worker_does_not_show(tmp_path):
    cells = [
        cell(scans, source=Source("synthetic", 2, seed, "", "any"), view=view)
        for seed in range(4)
        for view in ("frontal1", "laugh", "smile")
    ]
    run(cells, grid.Store(tmp_path / "serial"), grid.executor("serial"))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        with distributed.Client(cluster) as client:
            victim = next(iter(client.run(os.getpid).values()))

        def kill_when_something_is_done():
            while not list((tmp_path / "dask").rglob("*.npz")):
                time.sleep(0.05)
            os.kill(victim, signal.SIGKILL)

        killer = threading.Thread(target=kill_when_something_is_done)
        killer.start()
        executor = grid.executor(f"dask:{cluster.scheduler_address}")
        run(cells, grid.Store(tmp_path / "dask"), executor)
        killer.join()
    kept = [
        {p.name: p.read_bytes() for p in (tmp_path / name).rglob("*.npz")}
        for name in ("serial", "dask")
    ]
    assert kept[0] == kept[1]
    assert len(kept[0]) == len(cells)


def test_no_scheduler_is_one_line():
    with pytest.raises(ParameterError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        grid.executor("dask:tcp://127.0.0.1:9")
