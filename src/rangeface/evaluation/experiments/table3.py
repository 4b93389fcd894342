"""Table 3: twelve features with PCA and LDA, rectangle-cropped, neutral faces."""

from __future__ import annotations

from itertools import product

from rangeface.evaluation.experiments._experiment import Experiment, Results, ordering
from rangeface.evaluation.experiments.clean_scans import (
    FEATURES,
    READINGS,
    by_feature,
    cell_of,
    lda,
    ours,
    pca,
)
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.experiments.table2 import PLAIN, RING
from rangeface.evaluation.findings import Findings, judge
from rangeface.evaluation.grid import Cell

CLASSIFIERS = {"PCA": pca(), "LDA": lda()}
#: Test image (PCA, LDA), test sequence (PCA, LDA); %.
PAPER = {
    "depth (range image)": (45, 47, 45, 47),
    "3DLBP layer 1": (87, 85, 90, 85),
    "3DLBP layer 2": (25, 28, 40, 48),
    "3DLBP layer 3": (72, 77, 80, 87),
    "3DLBP layer 4": (27, 35, 18, 47),
    "Horizontal Sobel Operator": (38, 45, 48, 55),
    "Large Horizontal Gradient": (43, 50, 50, 55),
    "LBP8,1 u2": (88, 83, 88, 88),
    "LBP16,1 u2": (85, 85, 87, 88),
    "LBP16,2 riu2": (77, 80, 80, 87),
    "LBP8,1 ri": (72, 80, 80, 87),
    "LBP8,1 riu2": (92, 92, 90, 92),
}
TITLE = "Table 3: features with PCA and LDA"


def cells(source: Source) -> list[Cell]:
    """A cell a feature and classifier, and ours."""
    view = next(iter(source.probes.values()))
    return [
        cell_of(source, FEATURES[feature], classifier, view=view)
        for feature, classifier in product(FEATURES, CLASSIFIERS.values())
    ] + [ours(source, view)]


def tabulate(source: Source, results: Results) -> Findings:
    """The paper's layout."""
    view = next(iter(source.probes.values()))

    def at(feature: str, classifier: str) -> Cell:
        return cell_of(source, FEATURES[feature], CLASSIFIERS[classifier], view=view)

    caption = "Rank 1, % [95 %] (paper); 180 eigenvectors, rectangle-cropped"
    table = by_feature(
        "table3", caption, results, at=at, across=CLASSIFIERS, paper=PAPER, own=ours(source, view)
    )
    everything = list(product(FEATURES, CLASSIFIERS))
    verdicts = judge(
        [
            ordering(
                results, "LBP variants are better than range and gradient images",
                [at(f, c) for f, c in product(RING, CLASSIFIERS)],
                [at(f, c) for f, c in product(PLAIN, CLASSIFIERS)],
            ),
            ordering(
                results, "LBP8,1 riu2 is the best feature of a single image (against the rest)",
                [at("LBP8,1 riu2", c) for c in CLASSIFIERS],
                [at(f, c) for f, c in everything if f != "LBP8,1 riu2"],
            ),
            ordering(
                results, "3DLBP layers 2 and 4 are worse than layers 1 and 3",
                [at(f"3DLBP layer {n}", c) for n, c in product((1, 3), CLASSIFIERS)],
                [at(f"3DLBP layer {n}", c) for n, c in product((2, 4), CLASSIFIERS)],
            ),
        ]
    )  # fmt: skip
    return Findings(
        TITLE, "Which feature tells neutral faces apart with the usual classifiers?",
        readings=list(READINGS), tables=[table],
        verdicts=verdicts,
        shown=("LBP8,1 riu2, PCA, test image", at("LBP8,1 riu2", "PCA")),
    )  # fmt: skip


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=60, minutes=3.0)
