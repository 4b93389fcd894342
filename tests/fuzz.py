"""Mutated files of every format, read in a process that is watched.

``python tests/fuzz.py --cases 20000``: nothing may come out but an image, points or ScanError;
no death of the process, no hang (10 s), no more than 256 MB above the memory at the start, no
non-finite point called valid. Case k of a seed is always the same file.
"""

from __future__ import annotations

import argparse
import collections
import faulthandler
import json
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import scan_files

from rangeface import io
from rangeface.errors import ScanError

HANG_S = 10.0
MEMORY_MB = 256.0
HEAVY = {"vap", "rap3df", "swissranger"}  # a megabyte of text, or an unwrapping: one in twenty
NUMBERS = [0, 1, -1, 2, 127, 128, 255, 256, 32767, 65535, 65536, 2**31 - 1, -(2**31), 2**32 - 1]
WORDS = [b"-1", b"0", b"1e999", b"nan", b"-inf", b"4294967296", b"99999999999999999999", b"1e-999"]
WORDS += [b"2147483648", b"{", b"}", b"[", b"]", b'"', b"#", b"\0", b"DEF A", b"USE A", b"\\\n", b""]


def seeds() -> dict[str, dict[str, bytes]]:
    """The whole files that are mutated, by name; small, so that many fit into a minute."""
    grid = scan_files.face(12, 10, 9.0)
    takes_grid = set(scan_files.CLOUDS + scan_files.GRIDS + (scan_files.abs_gz,))
    out = {n: f(grid) if f in takes_grid else f() for n, f in scan_files.FILES.items()}
    out["swissranger_small"] = scan_files.swissranger(rows=12, columns=20)
    return out


def mutate(rng: np.random.Generator, data: bytes, other: bytes) -> bytes:
    """One to four changes: bits, numbers, words, pieces cut, doubled or moved, truncation."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        if not out:
            break
        at = int(rng.integers(len(out)))
        if rng.random() < 0.3:
            at = int(rng.integers(min(len(out), 200)))  # headers decide most
        length = int(min(2 ** rng.integers(0, 10), len(out) - at))
        kind = int(rng.integers(9))
        if kind == 0:
            out[at] ^= 1 << int(rng.integers(8))
        elif kind == 1:
            out[at : at + length] = rng.bytes(length)
        elif kind == 2:
            size = int(2 ** rng.integers(0, 4))
            number = NUMBERS[int(rng.integers(len(NUMBERS)))] % 256**size
            out[at : at + size] = number.to_bytes(size, "little" if rng.random() < 0.7 else "big")
        elif kind == 3:
            del out[at : at + length]
        elif kind == 4:
            out[at:at] = out[at : at + length] * int(rng.integers(1, 4))
        elif kind == 5:
            del out[at:]
        elif kind == 6:
            word = WORDS[int(rng.integers(len(WORDS)))]
            stop = at
            while stop < len(out) and stop < at + 12 and out[stop] > 32:
                stop += 1
            out[at:stop] = word
        elif kind == 7:
            start = int(rng.integers(max(len(other), 1)))
            out[at : at + length] = other[start : start + length]
        else:
            out[at : at + length] = bytes([int(rng.integers(256))]) * length
    return bytes(out)


def case(number: int, seed: int, files: dict[str, dict[str, bytes]]) -> dict[str, bytes]:
    """The files of a case; every third time one of those beside the scan is mutated too."""
    rng = np.random.default_rng((seed, number))
    names = list(files)
    name = names[int(rng.integers(len(names)))]
    if name in HEAVY and rng.random() < 0.95:
        name = "vrml2"
    other = files[names[int(rng.integers(len(names)))]]
    out = dict(files[name])
    first, *beside = out
    out[first] = mutate(rng, out[first], next(iter(other.values())))
    if beside and rng.random() < 0.3:
        out[beside[0]] = mutate(rng, out[beside[0]], b"")
    return out


def read(path: Path) -> str:
    """Read a scan in every way; the outcome in one word. Anything else is raised."""
    outcome = "read"
    try:
        image = io.read_scan(path)
        assert image.mask.any()
        assert not np.isinf(image.depth).any()
        assert np.isfinite(image.points[image.mask]).all()
    except ScanError as fault:
        outcome = fault.fault.name.lower()
        assert "\n" not in str(fault)
    try:
        assert np.isfinite(io.read_points(path).points).all()
        for image in io.read_frames(path):
            assert image.depth.dtype == np.float32
    except ScanError:
        pass
    return outcome


def work(start: int, stop: int, seed: int, folder: Path, seconds: float) -> None:
    """Read the cases [start, stop) and print the tally as JSON."""
    warnings.simplefilter("error")
    files = seeds()
    for name, whole in files.items():  # compile everything before the memory is measured
        (folder / name).mkdir()
        read(scan_files.write(whole, folder / name))
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    tally: collections.Counter[str] = collections.Counter()
    slowest, slowest_case, begin = 0.0, -1, time.perf_counter()
    last = folder / "last"
    number = start
    for number in range(start, stop):
        last.write_text(str(number))
        changed = case(number, seed, files)
        place = folder / "case"
        place.mkdir(exist_ok=True)
        path = scan_files.write(changed, place)
        faulthandler.dump_traceback_later(HANG_S, exit=True)
        before = time.perf_counter()
        tally[read(path)] += 1
        took = time.perf_counter() - before
        faulthandler.cancel_dump_traceback_later()
        if took > slowest:
            slowest, slowest_case = took, number
        for name in changed:
            (place / name).unlink()
        if seconds and time.perf_counter() - begin > seconds:
            break
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({
        "cases": number + 1 - start, "next": number + 1, "seed": seed,
        "seconds": round(time.perf_counter() - begin, 1), "slowest_s": round(slowest, 3),
        "slowest_case": slowest_case, "memory_mb": round(peak - base, 1), "outcomes": dict(tally),
    }))  # fmt: skip


def run(cases: int, *, start: int = 0, seed: int = 0, seconds: float = 0.0) -> dict:
    """Run the cases in a process of their own; its death is a failure of the last case."""
    with tempfile.TemporaryDirectory() as folder:
        worker = [sys.executable, __file__, "--work", folder, "--cases", str(cases)]
        worker += ["--start", str(start), "--seed", str(seed), "--seconds", str(seconds)]
        done = subprocess.run(worker, capture_output=True, text=True, check=False)
        if done.returncode:
            last = Path(folder) / "last"
            number = last.read_text() if last.exists() else "none"
            raise SystemExit(f"case {number} of seed {seed}: {done.stderr[-3000:]}")
    result = json.loads(done.stdout.splitlines()[-1])
    if result["memory_mb"] > MEMORY_MB:
        raise SystemExit(f"{result['memory_mb']} MB above the base: {result}")
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=0.0, help="stop after so long; 0 = never")
    parser.add_argument("--work", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.work:
        work(given.start, given.start + given.cases, given.seed, given.work, given.seconds)
    else:
        result = run(given.cases, start=given.start, seed=given.seed, seconds=given.seconds)
        print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
