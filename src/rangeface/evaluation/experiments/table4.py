"""Table 4: the Gaussian map in polar stereographic coordinates, neutral and smiling faces."""

from __future__ import annotations

from itertools import product

from rangeface.evaluation.experiments._experiment import Experiment, Results, ordering
from rangeface.evaluation.experiments.clean_scans import (
    ARG,
    N3,
    OURS,
    READINGS,
    cell_of,
    mlda,
    ours,
    rated,
)
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Entry, Findings, Table, judge
from rangeface.evaluation.grid import Cell

COMPONENTS = {"N3": N3, "arg π(N)": ARG}
#: Expression → N3, arg; %.
PAPER = {"neutral": (87, 90), "smiling": (90, 67)}
TITLE = "Table 4: surface normals"


def cells(source: Source) -> list[Cell]:
    """A cell a component and expression, and ours."""
    views = source.probes.values()
    return [
        cell_of(source, feature, mlda(), view=view)
        for feature, view in product(COMPONENTS.values(), views)
    ] + [ours(source, view) for view in views]


def tabulate(source: Source, results: Results) -> Findings:
    """The paper's layout."""

    def at(component: str, view: str) -> Cell:
        return cell_of(source, COMPONENTS[component], mlda(), view=view)

    rows = [
        [name]
        + [
            Entry(rated(results, at(component, view), "image"), printed)
            for component, printed in zip(COMPONENTS, PAPER.get(name, (None, None)), strict=True)
        ]
        + [Entry(rated(results, ours(source, view), "image"))]
        for name, view in source.probes.items()
    ]
    verdicts = []
    if "smiling" in source.probes:
        neutral, smiling = source.probes["neutral"], source.probes["smiling"]
        verdicts = judge(
            [
                ordering(
                    results, "The angle is not robust: better on neutral than on smiling faces",
                    [at("arg π(N)", neutral)], [at("arg π(N)", smiling)],
                ),
                ordering(
                    results, "On smiling faces N3 is better than the angle",
                    [at("N3", smiling)], [at("arg π(N)", smiling)],
                ),
            ]
        )  # fmt: skip
    caption = "Rank 1, % [95 %] (paper); MLDA with 180 eigenvectors and α = 6, rectangle-cropped"
    return Findings(
        TITLE, "Which component of the normals bears a smile?",
        readings=[*READINGS, "The angle is wrapped, as in the paper."],
        tables=[Table("table4", caption, ["expression", *COMPONENTS, OURS], rows)],
        verdicts=verdicts,
        shown=("arg π(N), MLDA, last row", at("arg π(N)", list(source.probes.values())[-1])),
    )  # fmt: skip


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=60, minutes=2.0)
