"""Time every stage against its peers, interleaved, on one thread; write bench.json and a table.

python -m benchmarks [NAME …]      only the rooms named (describe, io, register, …)
"""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"

import json
import sys
import time
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path

import numpy as np

ROOMS = tuple(
    sorted(p.stem.removeprefix("bench_") for p in Path(__file__).parent.glob("bench_*.py"))
)
BUDGET_S = 3.0  # of one stage, all arms together
MOST_ROUNDS, FEWEST_ROUNDS = 200, 5


def main(rooms: list[str]) -> None:
    unknown = sorted(set(rooms) - set(ROOMS))
    if unknown:
        sys.exit(f"unknown room {unknown[0]!r}; known: {', '.join(ROOMS)}")
    rows = [row for room in rooms or ROOMS for row in _room(room)]
    Path("bench.json").write_text(json.dumps(rows, indent=1, ensure_ascii=False) + "\n", "utf-8")
    print(f"bench.json: {len(rows)} rows")


def _room(room: str) -> Iterator[dict]:
    import cv2

    cv2.setNumThreads(1)
    for stage, size, arms in import_module(f"benchmarks.bench_{room}").stages():
        times = _interleaved(arms)
        peers = {arm: float(np.median(t)) for arm, t in times.items() if not arm.startswith("ours")}
        best = min(peers.values()) if peers else None
        for arm, t in times.items():
            median = float(np.median(t))
            low, high = np.percentile(t, [25, 75])
            factor = best / median if best is not None and arm.startswith("ours") else None
            against = "" if factor is None else f"{factor:8.1f} × best peer"
            print(f"{stage:38} {size:14} {arm:28} {median:10.4f} ms {against}", flush=True)
            yield {
                "stage": stage,
                "size": size,
                "arm": arm,
                "median_ms": median,
                "iqr_ms": float(high - low),
                "factor_vs_best_peer": factor,
            }


def _interleaved(arms: dict[str, Callable[[], object]]) -> dict[str, list[float]]:
    """Milliseconds of every call: all arms once a round, after a warm-up, until the budget ends."""
    for arm in arms.values():
        arm()
    times: dict[str, list[float]] = {name: [] for name in arms}
    start = time.perf_counter()
    for turn in range(MOST_ROUNDS):
        for name, arm in arms.items():
            begin = time.perf_counter()
            arm()
            times[name].append(1e3 * (time.perf_counter() - begin))
        if turn + 1 >= FEWEST_ROUNDS and time.perf_counter() - start > BUDGET_S:
            break
    return times


if __name__ == "__main__":
    main(sys.argv[1:])
