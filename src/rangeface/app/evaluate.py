"""`rangeface evaluate`: acquire once, compare, print, write."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from rangeface import classify, describe
from rangeface.app.console import console
from rangeface.app.progress import over
from rangeface.config import load_pipeline
from rangeface.errors import ParameterError, ScanError, ScanFault
from rangeface.evaluation.protocol import (
    Capture,
    Rates,
    Scores,
    Views,
    acquire,
    compare,
    rates,
    stage_times,
)
from rangeface.pipeline import FacePipeline, Head, step
from rangeface.types import Scan

GRID_FEATURES = ("depth", "n3", "normals", "lbp", "tdlbp")
GRID_CLASSIFIERS = ("pca", "lda", "mlda")


def run(
    dataset: str,
    scans: Sequence[Scan],
    pipeline: str,
    *,
    grid: bool,
    exclude: Sequence[str],
    reference: Path | None,
    json_file: Path | None,
    fmr: float | None = None,
) -> None:
    """Evaluate and report; failures of single files are printed and counted."""
    way = load_pipeline(pipeline)
    kept = _without(scans, exclude)
    near_frontal = None if reference is None else _marked(reference, kept)
    way = _adapted(way, kept)
    captures = acquire(way, over(kept, dataset))
    _print_failures(captures)
    views: Views = {}
    results: list[dict[str, Any]] = []
    for name, variant in _variants(way, pipeline, grid):
        scores = compare(variant, captures, views=views)
        subsets = _subsets(scores, near_frontal, fmr)
        _print_rates(name, subsets)
        results.append(
            {
                "dataset": dataset,
                "pipeline": name,
                "excluded": list(exclude),
                "fingerprint": scores.fingerprint,
                "ms_per_scan": stage_times(captures, scores.match_ms),
                "subset": {subset: r.to_json() for subset, r in subsets.items()},
            }
        )
    _print_times(results[0]["ms_per_scan"])
    if json_file is not None:
        text = json.dumps(results if grid else results[0], indent=2, ensure_ascii=False)
        json_file.write_text(text + "\n", encoding="utf-8")


def _adapted(way: FacePipeline, scans: Sequence[Scan]) -> FacePipeline:
    """The pipeline with the reference that the training (or gallery) captures give, if it wants."""
    if not way.adapt_reference:
        return way
    known = [s for s in scans if s.role == "train"] or [s for s in scans if s.role == "gallery"]
    captures = acquire(way, over(known, "reference face"))
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
    subsets = {}
    if near_frontal is not None:
        keep = np.array([c.scan.path in near_frontal for c in scores.probes])
        if keep.any():
            subsets["near_frontal"] = rates(scores.rows(keep), fmr=fmr)
    return {**subsets, "all": rates(scores, fmr=fmr)}


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
        "probes", "rank 1", "rank 5", "EER, per probe", "EER, raw", fnmr, "FTA", title=name
    )
    for subset, r in subsets.items():
        cells = (r.rank1, r.rank5, r.eer, r.eer_raw, r.fnmr, r.fta)
        table.add_row(f"{subset} ({r.n})", *(_cell(rate) for rate in cells))
    console.print(table)


def _cell(rate: Any) -> str:
    return f"{100 * rate.rate:.1f} [{100 * rate.low:.1f}, {100 * rate.high:.1f}]"


def _print_times(times: dict[str, float]) -> None:
    stages = "  ".join(f"{stage} {ms:.1f}" for stage, ms in times.items())
    console.print(f"median ms a scan: {stages}", highlight=False)
