"""Table 2: twelve features with MLDA, sphere- and rectangle-cropped, neutral faces."""

from __future__ import annotations

from itertools import product

from rangeface.evaluation.experiments._experiment import Experiment, Results, ordering
from rangeface.evaluation.experiments.clean_scans import (
    CROPS,
    FEATURES,
    READINGS,
    by_feature,
    cell_of,
    mlda,
    ours,
)
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Findings, judge
from rangeface.evaluation.grid import Cell

CLASSIFIER = mlda(60, alpha=8.0)
#: Test image (sphere, rectangle), test sequence (sphere, rectangle); %.
PAPER = {
    "depth (range image)": (45, 47, 60, 47),
    "3DLBP layer 1": (78, 87, 92, 88),
    "3DLBP layer 2": (33, 32, 45, 38),
    "3DLBP layer 3": (58, 77, 72, 90),
    "3DLBP layer 4": (15, 43, 13, 53),
    "Horizontal Sobel Operator": (32, 40, 43, 50),
    "Large Horizontal Gradient": (42, 50, 52, 55),
    "LBP8,1 u2": (77, 83, 87, 87),
    "LBP16,1 u2": (70, 82, 83, 87),
    "LBP16,2 riu2": (63, 77, 80, 80),
    "LBP8,1 ri": (48, 77, 65, 85),
    "LBP8,1 riu2": (75, 88, 88, 88),
}
PLAIN = ("depth (range image)", "Horizontal Sobel Operator", "Large Horizontal Gradient")
RING = tuple(name for name in FEATURES if name.startswith("LBP"))
TITLE = "Table 2: features with MLDA, two crops"


def cells(source: Source) -> list[Cell]:
    """A cell a feature and crop, and ours."""
    view = next(iter(source.probes.values()))
    return [
        cell_of(source, FEATURES[feature], CLASSIFIER, view=view, crop=crop)
        for crop, feature in product(CROPS.values(), FEATURES)
    ] + [ours(source, view)]


def tabulate(source: Source, results: Results) -> Findings:
    """The paper's layout."""
    view = next(iter(source.probes.values()))

    def at(feature: str, crop: str) -> Cell:
        return cell_of(source, FEATURES[feature], CLASSIFIER, view=view, crop=CROPS[crop])

    caption = "Rank 1, % [95 %] (paper); MLDA with 60 eigenvectors and α = 8"
    table = by_feature(
        "table2", caption, results, at=at, across=CROPS, paper=PAPER, own=ours(source, view)
    )
    ring, plain = ([at(f, "rectangle-cropped") for f in names] for names in (RING, PLAIN))
    others = [f for f in FEATURES if f != "LBP8,1 riu2"]
    verdicts = judge(
        [
            ordering(results, "LBP variants are better than range and gradients", ring, plain),
            ordering(
                results, "LBP8,1 riu2 is the best feature of a single image (against the rest)",
                [at("LBP8,1 riu2", "rectangle-cropped")],
                [at(f, "rectangle-cropped") for f in others],
            ),
            ordering(
                results, "For single images the rectangle is better than the sphere",
                [at(f, "rectangle-cropped") for f in FEATURES],
                [at(f, "sphere-cropped") for f in FEATURES],
            ),
        ]
    )  # fmt: skip
    return Findings(
        TITLE, "Which feature tells neutral faces apart, and does the crop matter?",
        readings=list(READINGS), tables=[table],
        verdicts=verdicts,
        shown=("LBP8,1 riu2, MLDA, rectangle", at("LBP8,1 riu2", "rectangle-cropped")),
    )  # fmt: skip


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=60, minutes=4.0)
