"""The examples run, and say what they promise."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


def _load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_an_example_runs_and_prints(path: Path, capsys) -> None:
    _load(path).main()
    assert capsys.readouterr().out.strip()


@pytest.mark.slow
def test_the_pipeline_recognises_objects_that_are_no_faces() -> None:
    right, tried = _load(next(p for p in EXAMPLES if p.stem == "09_objects")).main()
    assert tried == 20
    assert right >= 17  # chance is 2 of 20
