"""What takes long: the schema under fire, the example, a gallery rebuilt, the load."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from serving import Served

from rangeface.app.cli import main as command_line
from rangeface.client import Client
from rangeface.recognizer import FaceRecognizer

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]

#: A body that is no scan is valid for the schema, which knows bytes only; it is answered 422.
SCHEMATHESIS = """
[checks]
positive_data_acceptance.expected-statuses = ["2xx", "401", "403", "404", "422", "429"]
"""


def run(*command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *command], capture_output=True, text=True, cwd=ROOT,
        env={**os.environ, **environment},
    )  # fmt: skip


def test_the_schema_holds_under_generated_requests(tmp_path):
    """On a service of its own: the generator learns the names of those enrolled, and deletes."""
    pytest.importorskip("schemathesis")
    (tmp_path / "s.toml").write_text(SCHEMATHESIS)
    served = Served(tmp_path, {"workers": 1, "requests_per_s": 1e4, "burst": 1e4}).start()
    try:
        done = run(
            "-m", "schemathesis.cli", "--config-file", str(tmp_path / "s.toml"), "run",
            f"http://127.0.0.1:{served.port}/openapi.json", "--checks", "all", "--no-color",
            "--header", f"Authorization: Bearer {served.key}", "--max-examples", "15",
            "--seed", "1", "--report-dir", str(tmp_path),
        )  # fmt: skip
        _, text = served.ask("GET", "/metrics")
    finally:
        assert served.stop() == 0
    assert done.returncode == 0, done.stdout[-3000:]
    broken = re.findall(r'requests_total\{.*status="5\d\d"\}.*', text)
    assert all("/readyz" in line for line in broken), broken  # it was asked while it started


def test_the_door_opens_for_those_whom_the_desk_enrolled():
    path = ROOT / "examples/10_door_and_desk.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    seen = example.main()
    assert seen[:2] == ["opens for ann", "opens for bob"]
    assert set(seen[2:7]) == {"stays shut"}
    assert seen[7].startswith("waits")


def test_a_gallery_is_rebuilt_for_another_model(tmp_path, scan_of, monkeypatch, capsys):
    pytest.importorskip("cryptography")
    monkeypatch.setenv("RANGEFACE_GALLERY_KEY", "11" * 32)
    monkeypatch.chdir(tmp_path)

    def rangeface(*words: str) -> str:
        monkeypatch.setattr(sys, "argv", ["rangeface", *words])
        with pytest.raises(SystemExit):
            command_line()
        return capsys.readouterr().out

    shipped = FaceRecognizer.load(ROOT / "src/rangeface/data/default.model")
    way = shipped.pipeline
    other = replace(shipped, pipeline=replace(way, frontal=way.frontal.with_params(radius_mm=95.0)))
    other.save(tmp_path / "other.model")
    for person, name in ((1, "ann"), (2, "bob")):
        (tmp_path / f"{name}.npz").write_bytes(scan_of(person))
        rangeface("enroll", name, f"{name}.npz", "--gallery", "g.db", "--keep-frontal")
    (tmp_path / "probe.npz").write_bytes(scan_of(2, 1))
    asked = ("identify", "probe.npz", "--gallery", "g.db", "--model")
    assert "accepted" not in rangeface(*asked, "other.model")
    assert "rebuilt 2" in rangeface(
        "gallery", "rebuild", "--gallery", "g.db", "--model", "other.model"
    )
    assert "accepted bob" in rangeface(*asked, "other.model")
    assert "rebuilt" in rangeface("gallery", "audit", "--gallery", "g.db")
    assert "a copy" in rangeface("gallery", "backup", "copy.db", "--gallery", "g.db")
    assert "2 people" in rangeface("gallery", "export", "all.rfa", "--gallery", "copy.db")
    assert "2 people" in rangeface("gallery", "import", "all.rfa", "--gallery", "new.db")


def test_a_load_of_identifications_is_answered_without_an_error():
    """A short run; timings are no test's business, docs/results/service.md has the long one."""
    done = run("-m", "benchmarks.service_load", "--seconds", "15", "--rate", "4", "--people", "40")
    result = json.loads(done.stdout)
    assert result["errors"] == 0
    assert result["outcomes"] == {"right": 60}
    assert result["exit_status"] == 0


def test_the_command_line_makes_lists_and_revokes_keys(served, tmp_path, monkeypatch, capsys):
    def rangeface(*words: str) -> str:
        monkeypatch.setattr(sys, "argv", ["rangeface", *words, "--keys", str(served.keys.path)])
        with pytest.raises(SystemExit) as end:
            command_line()
        out, err = capsys.readouterr()
        return out if end.value.code in (0, None) else err

    text = rangeface("key", "add", "tablet", "--scope", "list", "--days", "1").strip()
    identity = text.split(".")[1]
    with Client(f"http://127.0.0.1:{served.port}", key=text) as client:
        assert {p.subject for p in client.people()} == {"ann", "bob"}
    listed = rangeface("key", "list")
    assert f"{identity}  tablet  until " in listed
    assert text.split(".")[2] not in listed
    assert "revoked" in rangeface("key", "revoke", identity)
    assert identity not in rangeface("key", "list")
    assert "unknown 'fly'" in rangeface("key", "add", "x", "--scope", "fly")
