"""Table 6: the best of each kind of feature, neutral and smiling faces."""

from __future__ import annotations

from rangeface.evaluation.experiments import table5
from rangeface.evaluation.experiments._experiment import Experiment, Results, ordering
from rangeface.evaluation.experiments.clean_scans import (
    FEATURES,
    N3,
    OURS,
    READINGS,
    cell_of,
    mlda,
    ours,
    pca,
    rated,
)
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.findings import Entry, Findings, Table, judge
from rangeface.evaluation.grid import Cell

METHODS = {
    "PCA from LBPs": (FEATURES["LBP8,1 riu2"], pca()),
    "MLDA for surface normals": (N3, mlda()),
}
#: Neutral, smiling; %.
PAPER = {"PCA from LBPs": (92, 82), "MLDA for surface normals": (87, 90), "profiles": (51, 48)}
PROFILE = table5.PROFILES["vert. central"]
#: What "neutral" and "smiling" mean among the views of table 5.
PROFILE_VIEWS = {"neutral": ("frontal1", "frontal2"), "smiling": ("laugh",)}
TITLE = "Table 6: best methods, neutral and smiling"


def cells(source: Source) -> list[Cell]:
    """The best methods, the central profile, and ours."""
    views = source.probes.values()
    learnt = [cell_of(source, f, c, view=view) for f, c in METHODS.values() for view in views]
    profile = [] if source.kind == "rap3df" else [table5.cell_of(source, PROFILE)]
    return learnt + [ours(source, view) for view in views] + profile


def tabulate(source: Source, results: Results) -> Findings:
    """The paper's layout."""
    names = list(source.probes)

    def at(method: str, name: str) -> Cell:
        return cell_of(source, *METHODS[method], view=source.probes[name])

    def printed(method: str, name: str) -> float | None:
        return PAPER[method][name == "smiling"] if name in PROFILE_VIEWS else None

    rows: list[list[object]] = [
        [m, *(Entry(rated(results, at(m, n), "image"), printed(m, n)) for n in names)]
        for m in METHODS
    ]
    if source.kind != "rap3df":
        profile = results(table5.cell_of(source, PROFILE))
        rows.append(
            ["profiles", *(
                table5.entry(profile, PROFILE_VIEWS[n], printed("profiles", n)) for n in names
            )]
        )  # fmt: skip
    rows.append(
        [OURS, *(Entry(rated(results, ours(source, source.probes[n]), "image")) for n in names)]
    )
    lbp, normals = METHODS
    verdicts = (
        judge(
            [
                ordering(
                    results, "On smiling faces normals with MLDA are better than LBP with PCA",
                    [at(normals, "smiling")], [at(lbp, "smiling")],
                ),
                ordering(
                    results, "LBP with PCA loses from neutral to smiling faces",
                    [at(lbp, "neutral")], [at(lbp, "smiling")],
                ),
            ]
        )
        if "smiling" in names
        else []
    )  # fmt: skip
    caption = "Rank 1 of a single image, % [95 %] (paper)"
    return Findings(
        TITLE, "Which method bears a change of expression?", readings=list(READINGS),
        tables=[Table("table6", caption, ["method", *names], rows)], verdicts=verdicts,
        shown=("normals with MLDA, last column", at(normals, names[-1])),
    )  # fmt: skip


EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=60, minutes=3.0)
