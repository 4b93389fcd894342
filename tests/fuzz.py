"""Mutated files of every format, read in a process that is watched.

``python tests/fuzz.py --cases 20000``: nothing may come out but an image, points or ScanError;
no death of the process, no hang (10 s), no more than 256 MB above the memory at the start, no
non-finite point called valid. Case k of a seed is always the same file.
"""

from __future__ import annotations

import argparse
import collections
import json
import mmap
import resource
import struct
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
CLOCK = struct.Struct("<qd")
HEAVY = {"vap", "rap3df", "swissranger"}  # a megabyte of text, or an unwrapping: one in twenty
NUMBERS = [0, 1, -1, 2, 127, 128, 255, 256, 32767, 65535, 65536, 2**31 - 1, -(2**31), 2**32 - 1]
WORDS = [b"-1", b"0", b"1e999", b"nan", b"-inf", b"4294967296", b"99999999999999999999", b"1e-999"]
WORDS += [
    b"2147483648",
    b"{",
    b"}",
    b"[",
    b"]",
    b'"',
    b"#",
    b"\0",
    b"DEF A",
    b"USE A",
    b"\\\n",
    b"",
]


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


def case(number: int, seed: int, files: dict[str, dict[str, bytes]]) -> tuple[str, dict]:
    """Which scan a case mutates, and the mutated files: the scan, sometimes one beside it."""
    rng = np.random.default_rng((seed, number))
    names = list(files)
    name = names[int(rng.integers(len(names)))]
    if name in HEAVY and rng.random() < 0.95:
        name = "vrml2"
    other = files[names[int(rng.integers(len(names)))]]
    first, *beside = files[name]
    changed = {first: mutate(rng, files[name][first], next(iter(other.values())))}
    if beside and rng.random() < 0.3:
        changed[beside[0]] = mutate(rng, files[name][beside[0]], b"")
    return name, changed


def read(path: Path, number: int) -> str:
    """Read a scan; the outcome in one word. Anything but ScanError is raised."""
    try:
        if number % 4 == 0:
            assert np.isfinite(io.read_points(path).points).all()
        if path.suffix == ".mcap" and number % 2:
            assert all(frame.depth.dtype == np.float32 for frame in io.read_frames(path))
        image = io.read_scan(path)
        assert image.mask.any()
        assert not np.isinf(image.depth).any()
        assert np.isfinite(image.points[image.mask]).all()
    except ScanError as fault:
        if "\n" in str(fault):
            raise
        return fault.fault.name.lower()
    return "read"


def work(start: int, stop: int, seed: int, folder: Path, seconds: float) -> None:
    """Read the cases [start, stop) and print the tally as JSON."""
    warnings.simplefilter("error")
    files = seeds()
    for name, whole in files.items():  # compile everything before the memory is measured
        (folder / name).mkdir()
        read(scan_files.write(whole, folder / name), 0)
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    tally: collections.Counter[str] = collections.Counter()
    slowest, slowest_case, begin = 0.0, -1, time.monotonic()
    clock = _clock(folder)
    number = start
    for number in range(start, stop):
        name, changed = case(number, seed, files)
        for file, data in changed.items():
            (folder / name / file).write_bytes(data)
        before = time.process_time()  # not the wall's: others may use this computer
        CLOCK.pack_into(clock, 0, number, time.monotonic())
        tally[read(folder / name / next(iter(changed)), number)] += 1
        took = time.process_time() - before
        if took > slowest:
            slowest, slowest_case = took, number
        for file in list(changed)[1:]:
            (folder / name / file).write_bytes(files[name][file])
        if seconds and time.monotonic() - begin > seconds:
            break
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({
        "cases": number + 1 - start, "next": number + 1, "seed": seed,
        "seconds": round(time.monotonic() - begin, 1), "slowest_s": round(slowest, 3),
        "slowest_case": slowest_case, "memory_mb": round(peak - base, 1), "outcomes": dict(tally),
    }))  # fmt: skip


def _clock(folder: Path) -> mmap.mmap:
    """Memory that both processes see: the case at hand and when it began."""
    with (folder / "clock").open("a+b") as file:
        file.truncate(CLOCK.size)
        return mmap.mmap(file.fileno(), CLOCK.size)


def run(cases: int, *, start: int = 0, seed: int = 0, seconds: float = 0.0) -> dict:
    """Run the cases in a process of their own; its death or hang is a failure of its last case."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        clock = _clock(folder)
        worker = [sys.executable, __file__, "--work", name, "--cases", str(cases)]
        worker += ["--start", str(start), "--seed", str(seed), "--seconds", str(seconds)]
        with (folder / "out").open("w+") as out, (folder / "err").open("w+") as err:
            process = subprocess.Popen(worker, stdout=out, stderr=err)
            while process.poll() is None:
                time.sleep(0.2)
                number, began = CLOCK.unpack_from(clock)
                if began and time.monotonic() - began > HANG_S and process.poll() is None:
                    process.kill()
            if process.wait():
                err.seek(0)
                number, _ = CLOCK.unpack_from(clock)
                raise SystemExit(f"case {number} of seed {seed} died: {err.read()[-3000:]}")
            out.seek(0)
            result = json.loads(out.read().splitlines()[-1])
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
