"""What an experiment or a score file cannot do is one line that says why."""

import builtins
import sys
from dataclasses import replace

import numpy as np
import pytest

from rangeface.app import cli
from rangeface.errors import DegenerateError, ParameterError, ScanError
from rangeface.evaluation import grid
from rangeface.evaluation.comparisons import Comparisons, read_scores
from rangeface.evaluation.experiments import EXPERIMENTS, models
from rangeface.evaluation.experiments.sources import scans_of, source
from rangeface.evaluation.findings import Claim, judge

#: Experiments that ask the model that ships.
OF_THE_MODEL = ("shipped_model", "non_faces", "passengers")


def refusal(monkeypatch, capsys, *arguments):
    """What the command line says, and nothing but one line."""
    monkeypatch.setattr(sys, "argv", ["rangeface", *map(str, arguments)])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    assert stop.value.code == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    return lines[0]


def test_an_unknown_experiment(monkeypatch, capsys, tmp_path):
    line = refusal(monkeypatch, capsys, "experiment", "table9", "--out", tmp_path)
    assert "unknown 'table9'; known: all, table1" in line


@pytest.mark.parametrize("kind", ["gavab", "rap3df", "ict"])
@pytest.mark.parametrize("name", ["table1", *OF_THE_MODEL])
def test_a_wrong_data_folder(monkeypatch, capsys, tmp_path, kind, name):
    data = f"{kind}:{tmp_path / 'nowhere'}"
    line = refusal(monkeypatch, capsys, "experiment", name, "--data", data, "--out", tmp_path)
    assert "nowhere" in line


@pytest.mark.parametrize("data", ["gavab", "synthetic:x", "frgc:x", ""])
def test_data_that_is_not_known(data):
    with pytest.raises(ParameterError, match=r"known: synthetic, ict:PATH"):
        source(data)


def test_too_few_people():
    with pytest.raises(ParameterError, match="persons, seed"):
        source("synthetic", persons=1)


@pytest.mark.parametrize("name", ["table1", "shipped_model"])
def test_a_full_disk(monkeypatch, capsys, tmp_path, name):
    def full(file, **arrays):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    arguments = ("experiment", name, "--persons", 2, "--executor", "serial", "--out", tmp_path)
    assert "No space left on device" in refusal(monkeypatch, capsys, *arguments)
    assert not [file for file in tmp_path.rglob("*") if file.is_file()]


@pytest.mark.parametrize("name", ["table1", *OF_THE_MODEL])
def test_the_extra_dask_is_missing(monkeypatch, capsys, tmp_path, name):
    whole = builtins.__import__

    def without(name, *rest, **more):
        if name == "distributed":
            raise ImportError(name)
        return whole(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    arguments = ("experiment", name, "--executor", "dask:tcp://x:1", "--out", tmp_path)
    assert "pip install 'rangeface[dask]'" in refusal(monkeypatch, capsys, *arguments)


def test_workers_that_die_again_and_again(monkeypatch, tmp_path):
    from concurrent.futures.process import BrokenProcessPool

    class Dead:
        def __enter__(self):
            raise BrokenProcessPool

        def __exit__(self, *_):
            return False

    executors = sys.modules[grid.Executor.__module__]
    monkeypatch.setattr(executors, "ProcessPoolExecutor", lambda *_, **__: Dead())
    with pytest.raises(OSError, match="die again and again"):
        list(grid.executor("processes")(grid.Store(tmp_path), [[]]))


@pytest.mark.parametrize(
    "name",
    [
        "table8",
        "operating_map",
        "best_system",
        "feature_noise",
        "table5",
        "registration_basin",
        *OF_THE_MODEL,
    ],
)
def test_data_without_what_an_experiment_needs(name, data_folder):
    people = source(f"rap3df:{data_folder / 'rap3df_2017'}", persons=4)
    with pytest.raises(ParameterError, match="data: "):
        EXPERIMENTS[name].cells(people)


def test_only_ict_is_compared_with_ict():
    with pytest.raises(ParameterError, match="needs ict:PATH"):
        EXPERIMENTS["population_against_ict"].cells(source(persons=2))


def test_passengers_walk_before_the_synthetic_camera_only():
    ict = replace(source(persons=2), kind="ict", folder="somewhere")
    with pytest.raises(ParameterError, match="synthetic only"):
        EXPERIMENTS["passengers"].cells(ict)


@pytest.mark.parametrize("name", OF_THE_MODEL)
def test_another_model_never_meets_this_ones_results(monkeypatch, name):
    people = source(persons=2)
    kept = {grid.key(cell) for wave in grid.waves(EXPERIMENTS[name].cells(people)) for cell in wave}
    monkeypatch.setattr(models, "shipped", lambda: "f" * 64)
    other = {
        grid.key(cell) for wave in grid.waves(EXPERIMENTS[name].cells(people)) for cell in wave
    }
    assert len(other) == len(kept)
    assert not other & kept


def test_a_worker_that_ships_another_model():
    with pytest.raises(ParameterError, match="asked for 012345678901; all workers need the same"):
        models.recognizer("0123456789" * 6 + "0123")


def test_a_view_that_nobody_has():
    with pytest.raises(ParameterError, match="unknown 'behind'"):
        scans_of(source(persons=2), "behind")


def test_a_claim_that_is_not_paired():
    with pytest.raises(ParameterError, match="must be paired"):
        judge([Claim("a > b", "me", [1, 0], [1], [0, 1])])


def test_score_files(tmp_path, monkeypatch, capsys):
    path = tmp_path / "scores.csv"
    with pytest.raises(ScanError, match="file not found"):
        read_scores(path)
    for text, says in (
        ("probe,reference,score\n", "no column 'mated'"),
        ("probe,reference,mated,score\na,A,maybe,1\n", "line 2: mated is 'maybe'"),
        ("probe,reference,mated,score\na,A,1,high\n", "line 2: score is 'high'"),
    ):
        path.write_text(text)
        with pytest.raises(ScanError, match=says):
            read_scores(path)
    path.write_text("probe,reference,mated,score\n")
    with pytest.raises(DegenerateError, match="no comparison"):
        read_scores(path)
    # a is A and B, b is B and not A
    path.write_text("probe,reference,mated,score\na,A,1,1\na,B,1,1\nb,B,1,1\nb,A,0,1\n")
    with pytest.raises(DegenerateError, match="contradicts itself"):
        read_scores(path)
    assert "contradicts itself" in refusal(monkeypatch, capsys, "evaluate", "scores", path)


def test_comparisons_of_one_kind_have_no_error_rates():
    table = np.array([[1.0], [2.0]])
    one = Comparisons(table, ("a", "b"), ("A",), ("A", "A"), ("A",))
    assert set(one.rates()) == {"rank 1", "rank 5", "failure to acquire", "failure to enrol"}
