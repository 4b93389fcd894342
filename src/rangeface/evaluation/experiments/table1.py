"""Table 1: depth and 3DLBP layer 1 with PCA, LDA and MLDA, neutral faces."""

from __future__ import annotations

from itertools import product

from rangeface.evaluation.experiments._experiment import Experiment, Results, ordering
from rangeface.evaluation.experiments.clean_scans import (
    FEATURES,
    READINGS,
    by_feature,
    cell_of,
    lda,
    mlda,
    ours,
    pca,
)
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Findings, judge
from rangeface.evaluation.grid import Cell

CLASSIFIERS = {"PCA": pca(), "LDA": lda(), "MLDA": mlda()}
#: Test image, then test sequence; PCA, LDA, MLDA; %.
PAPER = {
    "depth (range image)": (47, 47, 47, 47, 47, 50),
    "3DLBP layer 1": (87, 85, 88, 92, 85, 88),
}
TITLE = "Table 1: neutral faces, three classifiers"


def cells(source: Source) -> list[Cell]:
    """A cell a feature and classifier, and ours."""
    view = next(iter(source.probes.values()))
    grid = product(PAPER, CLASSIFIERS.values())
    return [cell_of(source, FEATURES[f], c, view=view) for f, c in grid] + [ours(source, view)]


def tabulate(source: Source, results: Results) -> Findings:
    """The paper's layout."""
    view = next(iter(source.probes.values()))

    def at(feature: str, classifier: str) -> Cell:
        return cell_of(source, FEATURES[feature], CLASSIFIERS[classifier], view=view)

    caption = "Rank 1, % [95 %] (paper); 180 eigenvectors, MLDA with α = 6"
    table = by_feature(
        "table1", caption, results, at=at, across=CLASSIFIERS, paper=PAPER, own=ours(source, view)
    )
    verdicts = judge(
        [
            ordering(
                results, f"3DLBP layer 1 is better than depth with {name}",
                [at("3DLBP layer 1", name)], [at("depth (range image)", name)],
            )
            for name in CLASSIFIERS
        ]
    )  # fmt: skip
    return Findings(
        TITLE, "Does 3DLBP tell neutral faces apart better than depth, whatever the classifier?",
        readings=list(READINGS), tables=[table],
        verdicts=verdicts,
        shown=("3DLBP layer 1, MLDA, test image", at("3DLBP layer 1", "MLDA")),
    )  # fmt: skip


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=60, minutes=2.0)
