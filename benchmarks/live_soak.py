"""The live recogniser for minutes on end: dropped frames, latency, memory.

    python -m benchmarks.live_soak --sensor sr3000 --rate 30 --minutes 5
    python -m benchmarks.live_soak --sensor structured-light --rate 15 --minutes 5
    python -m benchmarks.live_soak --minutes 30 --every 60

Two people, one of them enrolled, stand before the synthetic camera in a recording of 20 s, which
is played at its own speed, over and over, through the thread that a camera would have.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import argparse
import gc
import json
import tempfile
import time
from pathlib import Path

import numpy as np

from rangeface import sensors
from rangeface.app.models import load_model
from rangeface.gallery import MemoryGallery
from rangeface.live import LiveRecognizer
from rangeface.sources import (
    Newest,
    Recorder,
    SyntheticCamera,
    comings_and_goings,
    enrolment,
    open_source,
)

SECONDS = 20.0
KNOWN, STRANGER = 0, 900


def record(path: Path, sensor: str, rate_hz: float) -> None:
    walks = comings_and_goings(sensors.preset(sensor), [KNOWN, STRANGER], stay_s=SECONDS)
    camera = SyntheticCamera(sensor, walks, rate_hz=rate_hz, repeat=False, keep=False)
    with Recorder(path) as recorder:
        for frame in camera:
            recorder.write(frame)


def resident_mb() -> float:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return float("nan")


def run(path: Path, sensor: str, minutes: float, every_s: float) -> dict:
    recognizer = load_model(None)
    gallery = MemoryGallery()
    gallery.enroll("known", recognizer.template(enrolment(sensor, KNOWN), augment=True))
    warm_up(recognizer, gallery, path)
    latency, busy, stages, memory, names = [], [], {}, [], {}
    late = 0
    with (
        LiveRecognizer(recognizer, gallery) as live,
        Newest(open_source(f"mcap:{path}", repeat=True)) as source,
    ):
        start = due = time.monotonic()
        for frame in source:
            began = time.thread_time()
            answer = live.update(frame)
            busy.append(1e3 * (time.thread_time() - began))
            latency.append(answer.latency_ms)
            late += answer.stale
            for stage, took in answer.times_ms.items():
                stages.setdefault(stage, []).append(took)
            for track in answer.tracks:
                said = track.subject or str(track.verdict)
                names[said] = names.get(said, 0) + 1
            now = time.monotonic()
            if now >= due:
                due += every_s
                gc.collect()
                memory.append((round(now - start), round(resident_mb(), 1)))
                print(f"{now - start:6.0f} s  {len(latency)} frames  {answer.dropped} dropped  "
                      f"p99 {np.percentile(latency, 99):.0f} ms  {resident_mb():.0f} MB",
                      flush=True)  # fmt: skip
            if now - start > 60 * minutes:
                break
        took = time.monotonic() - start
    return {
        "sensor": sensor,
        "minutes": round(took / 60, 2),
        "frames": len(latency),
        "frames_per_s": round(len(latency) / took, 2),
        "dropped": answer.dropped,
        "ignored": late,
        "latency_ms": {f"p{p}": round(float(np.percentile(latency, p)), 1) for p in (50, 95, 99)},
        "processor_ms": {f"p{p}": round(float(np.percentile(busy, p)), 1) for p in (50, 95, 99)},
        "stages_ms_mean": {k: round(float(np.mean(v)), 2) for k, v in stages.items()},
        "said": names,
        "people": answer.people,
        "memory_mb": memory,
    }


def warm_up(recognizer, gallery, path: Path) -> None:
    """Compile and load everything before the clock runs."""
    with LiveRecognizer(recognizer, gallery, background=False) as live:
        for frame in open_source(f"mcap:{path}", speed=None):
            live.update(frame)
            if frame.time_s > 4.0:
                return


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sensor", default="sr3000")
    parser.add_argument("--rate", type=float, default=30.0, help="frames a second")
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--every", type=float, default=30.0, help="seconds between two lines")
    parser.add_argument("--recording", type=Path, help="made if it is missing")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = options.recording or Path(folder) / "two.mcap"
        if not path.exists():
            record(path, options.sensor, options.rate)
        result = run(path, options.sensor, options.minutes, options.every)
    print(json.dumps(result))
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
