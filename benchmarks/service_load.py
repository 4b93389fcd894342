"""Identifications a second against a large gallery, over real sockets: p50, p99, errors as JSON.

python -m benchmarks.service_load [--seconds 300] [--rate 20] [--people 10000] [--workers 2]
                                  [--model FILE]

A gallery of simulated strangers' templates and a few real enrolments is made, `rangeface serve` is
started on a free port, and probes of the enrolled are sent at a fixed rate, each when its moment
has come, whether or not earlier ones have been answered: a queue that grows shows as latency.
"""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import json
import signal
import socket
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from threading import local

import numpy as np

from rangeface import sensors, simulate
from rangeface.app.models import load_model
from rangeface.client import Client, ServiceError
from rangeface.gallery import SqliteGallery
from rangeface.io import read_scan, write_scan
from rangeface.types import Template

FRIENDS = 8


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--rate", type=float, default=20.0)
    parser.add_argument("--people", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--model", help="Model file; default: the one that ships.")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        probes = _populate(folder, given.people, given.model)
        with closing(socket.socket()) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        server = _start(folder, port, given.workers, given.model)
        try:
            result = _load(folder, port, probes, given.rate, given.seconds)
            result["server_cpu_s"], result["server_rss_mib"] = _spent(server.pid)
        finally:
            server.send_signal(signal.SIGTERM)
            status = server.wait(timeout=60)
    print(json.dumps({**vars(given), **result, "exit_status": status}))


def _populate(folder: Path, people: int, file: str | None) -> list[tuple[str, bytes]]:
    """Enrol; gives (name, scan) of the friends, other noise than at the enrolment."""
    model, camera = load_model(file and Path(file)), sensors.preset("sr3000").camera
    rng = np.random.default_rng(0)
    probes, records = [], []
    for person in range(FRIENDS):
        pose = simulate.pose(nose_tip_mm=(4.0, -6.0, 400.0))
        clean = simulate.render(simulate.head(person), camera, pose).image
        for noise in range(5):
            write_scan(folder / "scan.npz", simulate.add_noise(clean, 1.0, rng=rng))
            if noise == 0:
                seen = model.template(read_scan(folder / "scan.npz"), augment=True)
                records.append((f"friend {person}", seen, None))
            else:
                probes.append((f"friend {person}", (folder / "scan.npz").read_bytes()))
    # strangers: the cohort's own spread, so that nobody is near by accident of the numbers
    assert model.cohort is not None
    views = [len(v) for v in records[0][1].vectors]
    spread = [v.std(axis=0) for v in model.cohort.vectors]
    centre = [v.mean(axis=0) for v in model.cohort.vectors]
    for number in range(people - FRIENDS):
        vectors = []
        for mean, sigma, count in zip(centre, spread, views, strict=True):
            face = mean + sigma * rng.standard_normal(len(sigma))
            views_of_it = face + 0.1 * sigma * rng.standard_normal((count, len(sigma)))
            vectors.append(views_of_it.astype(np.float32))
        stranger = Template(tuple(vectors), model.pipeline.fingerprint)
        records.append((f"stranger {number}", stranger, None))
    with SqliteGallery(folder / "gallery.db") as gallery:
        gallery.enroll_many(records)
    return probes


def _start(folder: Path, port: int, workers: int, model: str | None) -> subprocess.Popen[bytes]:
    program = "from rangeface.app.cli import main; main()"
    command = [
        sys.executable, "-c", program, "serve", "--gallery", str(folder / "gallery.db"),
        "--keys", str(folder / "load.keys"), "--port", str(port), "--workers", str(workers),
        *(["--model", str(Path(model).resolve())] if model else []),
    ]  # fmt: skip
    log = (folder / "service.log").open("wb")
    server = subprocess.Popen(command, stdout=log, stderr=log)
    for _ in range(3000):
        try:
            with closing(socket.create_connection(("127.0.0.1", port), timeout=5)) as link:
                link.sendall(b"GET /readyz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
                if b" 200 " in link.recv(100):
                    return server
        except OSError:
            pass
        if server.poll() is not None:
            break
        time.sleep(0.2)
    sys.exit((folder / "service.log").read_text())


def _load(
    folder: Path, port: int, probes: list[tuple[str, bytes]], rate: float, seconds: float
) -> dict[str, object]:
    own = local()

    def once(number: int, due: float) -> tuple[float, str]:
        if not hasattr(own, "client"):
            own.client = Client(f"http://127.0.0.1:{port}", key_file=folder / "load.key")
        name, scan = probes[number % len(probes)]
        try:
            decision = own.client.identify(scan)
            outcome = "right" if decision.subject == name else str(decision.verdict)
        except ServiceError as error:
            outcome = f"error {error.reason}"
        return time.perf_counter() - due, outcome

    answers = []
    with ThreadPoolExecutor(32) as pool:
        start = time.perf_counter() + 0.5
        for number in range(int(rate * seconds)):
            due = start + number / rate
            time.sleep(max(0.0, due - time.perf_counter()))
            answers.append(pool.submit(once, number, due))
        taken = [answer.result() for answer in answers]
    times_ms = 1e3 * np.array([t for t, _ in taken])
    outcomes = [outcome for _, outcome in taken]
    return {
        "identifications": len(taken),
        "p50_ms": round(float(np.percentile(times_ms, 50)), 1),
        "p99_ms": round(float(np.percentile(times_ms, 99)), 1),
        "worst_ms": round(float(times_ms.max()), 1),
        "errors": sum(outcome.startswith("error") for outcome in outcomes),
        "outcomes": {outcome: outcomes.count(outcome) for outcome in sorted(set(outcomes))},
    }


def _spent(process: int) -> tuple[float, float]:
    """CPU seconds of the service itself (not its workers) and resident memory, MiB; from /proc."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except OSError:
        return float("nan"), float("nan")
    ticks = int(fields[11]) + int(fields[12])
    page, tick = os.sysconf("SC_PAGE_SIZE"), os.sysconf("SC_CLK_TCK")
    return round(ticks / tick, 1), round(pages * page / 2**20, 1)


if __name__ == "__main__":
    main()
