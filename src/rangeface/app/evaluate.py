"""`rangeface evaluate`: acquire once, compare, print, write."""

from __future__ import annotations

import csv
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from rangeface import classify, describe
from rangeface.app import evaluation_report, fusion
from rangeface.app.console import console
from rangeface.app.models import load_model
from rangeface.app.progress import over
from rangeface.config import load_pipeline
from rangeface.errors import ParameterError, ScanError, ScanFault
from rangeface.evaluation.captures import learners
from rangeface.evaluation.error_rates import fmr as fmr_at
from rangeface.evaluation.error_rates import fnmr as fnmr_at
from rangeface.evaluation.error_rates import mated_nonmated
from rangeface.evaluation.protocol import (
    Capture,
    Rates,
    Scores,
    Views,
    acquire,
    compare,
    rates,
    score,
    stage_times,
)
from rangeface.pipeline import FacePipeline, Head, step
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Scan

GRID_FEATURES = ("depth", "n3", "normals", "lbp", "tdlbp")
GRID_CLASSIFIERS = ("pca", "lda", "mlda")
#: FMRs at whose calibrated thresholds a model is judged; fewer pairs than this cannot show one.
_PROMISED, _RULE_OF_THREE = (0.01, 0.001), 3.0


def run(
    dataset: str,
    scans: Sequence[Scan],
    pipeline: str | None,
    *,
    grid: bool,
    model: Path | None = None,
    exclude: Sequence[str],
    reference: Path | None,
    json_file: Path | None,
    fmr: float | None = None,
    detail: bool = False,
    against: str | None = None,
    report: Path | None = None,
) -> None:
    """Evaluate and report; failures of single files are printed and counted.

    With a pipeline, it learns from the data set's own training (or gallery) captures; without
    one, a model scores that has seen none of these people.
    """
    start = time.perf_counter()
    if pipeline is not None and model is not None:
        raise ParameterError("pipeline, model: give one of them; a model brings its pipeline")
    recognizer = None if pipeline or grid else load_model(model)
    way = recognizer.pipeline if recognizer else load_pipeline(pipeline or "default")
    kept = _without(scans, exclude)
    near_frontal = None if reference is None else _marked(reference, kept)
    way = _adapted(way, kept) if recognizer is None else way
    captures = acquire(way, over(kept, dataset))
    _print_failures(captures)
    views: Views = {}
    results: list[dict[str, Any]] = []
    runs: list[evaluation_report.Run] = []
    label = pipeline or (f"model {model or 'that ships'}" if recognizer else "default")
    for name, variant in _variants(way, label, grid):
        if recognizer is not None:
            scores = score(recognizer, captures, views=views)
        else:
            scores = compare(variant, captures, views=views)
        subsets = _subsets(scores, near_frontal, fmr)
        runs.append((name, scores, subsets))
        _print_rates(name, subsets)
        results.append(
            {
                "dataset": dataset,
                "pipeline": name,
                "excluded": list(exclude),
                "fingerprint": scores.fingerprint,
                "ms_per_scan": stage_times(captures, scores.match_ms),
                "subset": {subset: r.to_json() for subset, r in subsets.items()},
                **({} if recognizer is None else _promised(recognizer, scores)),
                **_more(scores, captures, variant, near_frontal, detail, against, kept),
            }
        )
    _print_times(results[0]["ms_per_scan"])
    if json_file is not None:
        text = json.dumps(results if grid else results[0], indent=2, ensure_ascii=False)
        json_file.write_text(text + "\n", encoding="utf-8")
    if report is not None:
        evaluation_report.write(report, dataset, runs, captures, time.perf_counter() - start)


def _more(
    scores: Scores,
    captures: list[Capture],
    way: FacePipeline,
    near_frontal: set[Path] | None,
    detail: bool,
    against: str | None,
    scans: Sequence[Scan],
) -> dict[str, Any]:
    """What --detail and --against add."""
    masks = _masks(scores, near_frontal)
    out = fusion.details(scores, captures, way, masks) if detail else {}
    if against is not None:
        rival = _adapted(load_pipeline(against), scans)
        theirs = compare(rival, acquire(rival, over(scans, against)))
        out["paired"] = fusion.paired(scores, theirs, against, masks)
    return out


def _masks(scores: Scores, near_frontal: set[Path] | None) -> dict[str, NDArray[np.bool_]]:
    """Which probes each subset holds."""
    everything = {"all": np.ones(len(scores.probes), bool)}
    keep = np.array([c.scan.path in (near_frontal or ()) for c in scores.probes])
    return {"near_frontal": keep, **everything} if keep.any() else everything


def _adapted(way: FacePipeline, scans: Sequence[Scan]) -> FacePipeline:
    """The pipeline with the reference that the training (or gallery) captures give, if it wants."""
    if not way.adapt_reference:
        return way
    captures = acquire(way, over(learners(scans), "reference face"))
    return way.adapted([c.trace for c in captures if c.trace is not None])


def _without(scans: Sequence[Scan], exclude: Sequence[str]) -> list[Scan]:
    known = {scan.subject for scan in scans}
    for subject in exclude:
        if subject not in known:
            raise ParameterError(f"exclude: no subject {subject!r} in this data set")
    return [scan for scan in scans if scan.subject not in exclude]


def _marked(reference: Path, scans: Sequence[Scan]) -> set[Path]:
    """Paths of the captures that the CSV marks as near-frontal."""
    if not reference.is_file():
        raise ScanError(reference, ScanFault.MISSING, "the CSV of --reference")
    with reference.open(newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    if not rows or not {"capture", "near_frontal"} <= set(rows[0]):
        raise ScanError(reference, ScanFault.MALFORMED, "columns capture and near_frontal needed")
    marks = {row["capture"]: row["near_frontal"].strip() == "1" for row in rows}
    found = {scan.path: mark for scan in scans if (mark := _mark(scan.path, marks)) is not None}
    missing = [scan.path for scan in scans if scan.path not in found]
    if missing:
        raise ScanError(
            reference,
            ScanFault.MALFORMED,
            f"{len(missing)} captures have no row, e.g. {missing[0]}",
        )
    return {path for path, mark in found.items() if mark}


def _mark(path: Path, marks: dict[str, bool]) -> bool | None:
    """The mark of the longest tail of the path that the CSV names."""
    for start in range(len(path.parts)):
        mark = marks.get("/".join(path.parts[start:]))
        if mark is not None:
            return mark
    return None


def _variants(way: FacePipeline, name: str, grid: bool) -> list[tuple[str, FacePipeline]]:
    if not grid:
        return [(name, way)]
    return [
        (
            f"{feature} + {classifier}",
            replace(
                way,
                heads=(Head(step(describe.METHODS[feature]), classify.METHODS[classifier]()),),
            ),
        )
        for feature in GRID_FEATURES
        for classifier in GRID_CLASSIFIERS
    ]


def _subsets(scores: Scores, near_frontal: set[Path] | None, fmr: float | None) -> dict[str, Rates]:
    masks = _masks(scores, near_frontal)
    return {subset: rates(scores.rows(keep), fmr=fmr) for subset, keep in masks.items()}


def _print_failures(captures: Sequence[Capture]) -> None:
    for capture in captures:
        if not capture.acquired:
            console.print(f"{capture.scan.path}: {capture.failure}", style="yellow", markup=False)
    count = sum(not c.acquired for c in captures)
    if count:
        console.print(f"{count} of {len(captures)} captures failed; they count as errors")


def _print_rates(name: str, subsets: dict[str, Rates]) -> None:
    fmr = next(iter(subsets.values())).fmr
    fnmr = f"FNMR at FMR {100 * fmr:.3g} %"
    table = Table(
        "probes", "rank 1", "rank 5", "EER, per probe", "EER, 1:1", fnmr, "FTA", title=name
    )
    for subset, r in subsets.items():
        cells = (r.rank1, r.rank5, r.eer, r.eer_raw, r.fnmr, r.fta)
        table.add_row(f"{subset} ({r.n})", *(_cell(rate) for rate in cells))
    console.print(table)


def _promised(recognizer: FaceRecognizer, scores: Scores) -> dict[str, Any]:
    """FMR and FNMR found at the thresholds that the model's calibration gives, printed too."""
    found = {}
    mated, nonmated = mated_nonmated(scores.table, scores.probe_subjects, scores.people)
    for asked in _PROMISED:
        if recognizer.nonmated.size * asked < _RULE_OF_THREE:
            continue
        threshold = recognizer.threshold(asked)
        rates = {"fmr": str(fmr_at(nonmated, threshold)), "fnmr": str(fnmr_at(mated, threshold))}
        console.print(
            f"at the calibration's threshold for an FMR of {100 * asked:g} %: "
            f"FMR {rates['fmr']}, FNMR {rates['fnmr']}",
            highlight=False,
        )
        found[f"{asked:g}"] = rates
    return {"at_calibrated_fmr": found}


def _cell(rate: Any) -> str:
    return f"{100 * rate.rate:.1f} [{100 * rate.low:.1f}, {100 * rate.high:.1f}]"


def _print_times(times: dict[str, float]) -> None:
    stages = "  ".join(f"{stage} {ms:.1f}" for stage, ms in times.items())
    console.print(f"median ms a scan: {stages}", highlight=False)
