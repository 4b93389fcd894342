"""The command line as a user calls it, a folder of captures, and one service for many tests."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from serving import Served
from tests.conftest import sr3000_face

from rangeface import sensors, simulate
from rangeface.app import cli
from rangeface.io import write_scan


@pytest.fixture
def rangeface(capsys, monkeypatch):
    """Call the command line: status, standard output, standard error."""

    def call(*args: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["rangeface", *map(str, args)])
        try:
            cli.main()
            status = 0
        except SystemExit as stop:
            status = int(stop.code or 0)
        out, err = capsys.readouterr()
        return status, out, err

    return call


@pytest.fixture(scope="module")
def folder(request, tmp_path_factory) -> Path:
    """Captures of the test module's `PEOPLE` as files, with an index: a user's own data."""
    root: Path = tmp_path_factory.mktemp("captures")
    lines = ["path,subject,role,view,session"]
    for person in request.module.PEOPLE:
        for role, session in (("gallery", 0), ("probe", 1)):
            name = f"{person}-{role}.npz"
            write_scan(root / name, sr3000_face(person, session=session, noise=session)[0])
            lines.append(f"{name},{person},{role},frontal,{session}")
    (root / "index.csv").write_text("\n".join(lines) + "\n")
    return root


@pytest.fixture(scope="session")
def scan_of(tmp_path_factory):
    """The bytes of a scan of a simulated person; `noise` numbers the captures."""
    folder: Path = tmp_path_factory.mktemp("scans")
    camera = sensors.preset("sr3000").camera

    def scan(person: int, noise: int = 0, *, ending: str = "npz") -> bytes:
        path = folder / f"{person}-{noise}.{ending}"
        if not path.exists():
            pose = simulate.pose(nose_tip_mm=(4.0, -6.0, 400.0))
            clean = simulate.render(simulate.head(person), camera, pose).image
            write_scan(path, simulate.add_noise(clean, 1.0, rng=np.random.default_rng(noise)))
        return path.read_bytes()

    return scan


@pytest.fixture(scope="session")
def served(tmp_path_factory, scan_of) -> Iterator[Served]:
    """A service with short waits; "ann" (person 1) and "bob" (person 2) are enrolled."""
    service = Served(
        tmp_path_factory.mktemp("served"),
        {
            "workers": 1, "header_s": 1.0, "body_s": 1.5, "pause_s": 0.5, "failures": 5,
            "stop": 12, "max_body_bytes": 4 << 20, "requests_per_s": 1e4, "burst": 1e4,
        },
    ).start()  # fmt: skip
    try:
        for person, name in ((1, "ann"), (2, "bob")):
            status, answer = service.ask("POST", "/v1/people", scan_of(person), subject=name)
            assert status == 201, answer
        yield service
    finally:
        service.stop()
