"""The report of `rangeface evaluate`: the same page, tables and score file as an experiment's."""

from __future__ import annotations

import hashlib
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from rangeface.app.console import console
from rangeface.evaluation.comparisons import Comparisons, read_scores
from rangeface.evaluation.findings import Findings, Table
from rangeface.evaluation.pictures import png
from rangeface.evaluation.protocol import Capture, Rates, Scores
from rangeface.evaluation.publish import Provenance, publish
from rangeface.evaluation.score_plots import pairs_figure
from rangeface.types import RangeImage

Run = tuple[str, Scores, Mapping[str, Rates]]


def write(
    folder: Path, dataset: str, runs: Sequence[Run], captures: Sequence[Capture], seconds: float
) -> None:
    """Report what was evaluated; curves and pairs are those of the first pipeline."""
    name, scores, _ = runs[0]
    comparisons = comparisons_of(scores)
    findings = Findings(
        f"Evaluation on {dataset}", "Who is recognised, and how surely?",
        tables=[_rates(runs), _failures(captures)],
        comparisons=(name, comparisons),
        figures=[_pairs(name, scores, comparisons, captures)],
    )  # fmt: skip
    _publish(findings, folder, f"{dataset}, {len(captures)} captures", scores.fingerprint, seconds)


def judge(file: Path, folder: Path | None) -> None:
    """Print the rates of a score file, and report them if a folder is given."""
    comparisons = read_scores(file)
    for which, rate in comparisons.rates().items():
        console.print(f"{which}: {rate}", highlight=False)
    if folder is not None:
        findings = Findings(
            f"Scores of {file.name}", "How well do these scores tell people apart?",
            comparisons=(file.name, comparisons),
        )  # fmt: skip
        digest = hashlib.sha256(file.read_bytes()).hexdigest()
        _publish(findings, folder, str(file), digest, 0.0)


def comparisons_of(scores: Scores) -> Comparisons:
    """Scores of a protocol with names: a probe by its file, a person by the subject."""
    return Comparisons(
        scores.table,
        tuple(str(capture.scan.path) for capture in scores.probes),
        scores.people,
        scores.probe_subjects,
        scores.people,
    )


def _publish(findings: Findings, folder: Path, data: str, digest: str, seconds: float) -> None:
    command = " ".join(["rangeface", *sys.argv[1:]])
    report = publish(findings, folder, Provenance(command, data, digest, seconds, "1 process"))
    console.print(str(report), highlight=False)


def _rates(runs: Sequence[Run]) -> Table:
    rows = []
    for name, _, subsets in runs:
        for subset, r in subsets.items():
            rates = (r.rank1, r.rank5, r.eer, r.eer_raw, r.fnmr, r.fta)
            rows.append((name, f"{subset} ({r.n})", *map(str, rates)))
    fmr = 100 * next(iter(runs[0][2].values())).fmr
    header = ("pipeline", "probes", "rank 1", "rank 5", "EER, per probe", "EER, raw",
              f"FNMR at FMR {fmr:.3g} %", "FTA")  # fmt: skip
    return Table("evaluation", "Rates with 95 % intervals and counts", header, rows)


def _failures(captures: Sequence[Capture]) -> Table:
    lost = Counter((c.scan.role, c.failure) for c in captures if not c.acquired)
    rows: list[tuple[object, ...]] = [
        (role or "no role", reason, count) for (role, reason), count in sorted(lost.items())
    ]
    for role in sorted({c.scan.role for c in captures}):
        good = sum(c.acquired and c.scan.role == role for c in captures)
        rows.append((role or "no role", "acquired", good))
    return Table("failures", "How far the captures came", ("role", "outcome", "captures"), rows)


def _pairs(
    name: str, scores: Scores, comparisons: Comparisons, captures: Sequence[Capture]
) -> tuple[str, bytes]:
    enrolled = {c.scan.subject: c for c in captures if c.scan.role == "gallery" and c.acquired}

    def frontal(capture: Capture | None) -> RangeImage | None:
        return None if capture is None or capture.trace is None else capture.trace.frontal

    figure = pairs_figure(
        comparisons,
        lambda row: frontal(scores.probes[row]),
        lambda column: frontal(enrolled.get(scores.people[column])),
    )
    caption = "Worst mated pairs (first row) and worst non-mated pairs: probe, enrolled face"
    return f"{caption}; {name}", png(figure)
