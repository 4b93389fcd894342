"""Which α and how many eigenvectors? The search behind table 1's best rates."""

from __future__ import annotations

from itertools import product

from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.clean_scans import (
    FEATURES,
    N3,
    READINGS,
    cell_of,
    lda,
    mlda,
    pca,
    rated,
)
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Entry, Findings, Table
from rangeface.evaluation.grid import Cell
from rangeface.pipeline import Step

ALPHAS = (0.0, 0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 12.0, 20.0)
COUNTS = (5, 10, 20, 40, 60, 100, 180)
SWEPT = {
    "depth (range image)": FEATURES["depth (range image)"],
    "3DLBP layer 1": FEATURES["3DLBP layer 1"],
    "N3": N3,
}
CLASSIFIERS = {"PCA": pca, "LDA": lda, "MLDA, α = 6": mlda}
TITLE = "Sweeps: α and the number of eigenvectors"


def cells(source: Source) -> list[Cell]:
    """All points of both sweeps, on the hardest view."""
    return [
        _at(source, feature, classifier)
        for feature in SWEPT
        for classifier in (
            *(mlda(alpha=alpha) for alpha in ALPHAS),
            *(kind(count) for kind, count in product(CLASSIFIERS.values(), COUNTS)),
        )
    ]


def _at(source: Source, feature: str, classifier: Step) -> Cell:
    hardest = list(source.probes.values())[-1]
    return cell_of(source, SWEPT[feature], classifier, view=hardest)


def tabulate(source: Source, results: Results) -> Findings:
    """Rates against α, and against the number of eigenvectors."""

    def entry(feature: str, classifier: Step) -> Entry:
        return Entry(rated(results, _at(source, feature, classifier), "image"))

    probes = list(source.probes)[-1]
    alphas = Table(
        "alpha", f"MLDA with 180 eigenvectors against α, {probes} probes: rank 1, % [95 %]",
        ["feature", *(f"α = {alpha:g}" for alpha in ALPHAS)],
        [[f, *(entry(f, mlda(alpha=alpha)) for alpha in ALPHAS)] for f in SWEPT],
    )  # fmt: skip
    counts = Table(
        "eigenvectors", f"Rank 1 against the number of eigenvectors, {probes} probes, % [95 %]",
        ["feature", "classifier", *map(str, COUNTS)],
        [
            [f, name, *(entry(f, kind(count)) for count in COUNTS)]
            for f, (name, kind) in product(SWEPT, CLASSIFIERS.items())
        ],
    )  # fmt: skip
    return Findings(
        TITLE, "How much do the paper's choices of α and of the number of eigenvectors matter?",
        readings=[
            *READINGS,
            "The paper searched α and the number of eigenvectors on its test set and prints the "
            "best; here every point is shown. Smiling probes, because neutral ones saturate.",
        ],
        tables=[alphas, counts],
    )  # fmt: skip


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=60, minutes=3.0)
