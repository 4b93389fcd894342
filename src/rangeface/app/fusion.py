"""What `rangeface evaluate --detail` adds: heads left out, weights held out, every error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from rangeface.app.console import console
from rangeface.evaluation.fusion import (
    Miss,
    cross_validated,
    misses,
    only_head,
    right,
    without_head,
)
from rangeface.evaluation.protocol import Capture, Scores, rates
from rangeface.numerics.statistics import mcnemar
from rangeface.pipeline import FacePipeline

#: Deals people into folds: the same ones every time.
_SEED = 0

Masks = Mapping[str, NDArray[np.bool_]]


def details(
    scores: Scores, captures: list[Capture], way: FacePipeline, masks: Masks
) -> dict[str, Any]:
    """Print each head alone and left out, weights cross-validated over people, every error."""
    table = Table("fusion", *(f"rank 1, {subset}" for subset in masks), "EER, per probe")
    rows: dict[str, Any] = {}
    for name, variant in _variants(scores, way).items():
        found = {subset: rates(variant.rows(keep)) for subset, keep in masks.items()}
        table.add_row(
            name,
            *(str(r.rank1) for r in found.values()),
            " / ".join(f"{100 * r.eer.rate:.1f}" for r in found.values()),
        )
        rows[name] = {subset: r.to_json() for subset, r in found.items()}
    console.print(table)
    wrong = misses(scores, captures)
    _print_misses(wrong, masks)
    return {"fusion": rows, "errors": [miss.__dict__ for miss in wrong]}


def paired(scores: Scores, other: Scores, name: str, masks: Masks) -> dict[str, Any]:
    """Print McNemar's exact test of rank 1 against another pipeline, probe by probe."""
    mine = dict(zip((c.scan.path for c in scores.probes), right(scores), strict=True))
    theirs = dict(zip((c.scan.path for c in other.probes), right(other), strict=True))
    out = {}
    for subset, keep in masks.items():
        paths = [c.scan.path for c, kept in zip(scores.probes, keep, strict=True) if kept]
        a, b = np.array([mine[p] for p in paths]), np.array([theirs[p] for p in paths])
        p = mcnemar(a, b)
        gained, lost = int((a & ~b).sum()), int((b & ~a).sum())
        console.print(
            f"{subset}: {name} has {int(b.sum())} of {len(b)} right, this has {int(a.sum())}: "
            f"{gained} gained, {lost} lost, McNemar p = {p:.2g}",
            highlight=False,
        )
        out[subset] = {"gained": gained, "lost": lost, "p": p}
    return {"against": name, **out}


def _variants(scores: Scores, way: FacePipeline) -> dict[str, Scores]:
    names = [f"{head.describe.name} + {type(head.classify).__name__}" for head in way.heads]
    variants = {"as shipped": scores}
    if len(names) < 2:
        return variants
    variants["weights cross-validated over people"], weights = cross_validated(
        scores, rng=np.random.default_rng(_SEED)
    )
    shares = ", ".join(f"{100 * share:.0f}" for share in weights.mean(axis=0))
    console.print(f"cross-validated weights, mean of the folds, %: {shares}", highlight=False)
    for k, name in enumerate(names):
        variants[f"without {name}"] = without_head(scores, k)
    for k, name in enumerate(names):
        variants[f"only {name}"] = only_head(scores, k)
    return variants


def _print_misses(wrong: Sequence[Miss], masks: Masks) -> None:
    table = Table("probe", "subject", "subset", "rank", "cause", title=f"{len(wrong)} errors")
    for miss in wrong:
        subset = next(name for name, keep in masks.items() if keep[miss.probe])
        rank = f"{miss.rank:.0f}" if np.isfinite(miss.rank) else "–"
        table.add_row(str(miss.probe), miss.subject, subset, rank, "; ".join(miss.causes))
    console.print(table)
