"""Findings as files: an HTML report, and every table as CSV, Markdown and LaTeX."""

from __future__ import annotations

import csv
import io
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import rangeface
from rangeface.evaluation.comparisons import Comparisons, write_scores
from rangeface.evaluation.findings import Findings, Table, Verdict
from rangeface.evaluation.pictures import png
from rangeface.evaluation.report import Report
from rangeface.evaluation.score_plots import score_figure


@dataclass(frozen=True)
class Provenance:
    """Where findings come from.

    Parameters
    ----------
    command : str
        That gives them again.
    data : str
        What they were computed from.
    hash : str
        Of everything that the numbers depend on: keys of cells, or a pipeline's fingerprint.
    seconds : float
        How long this run took.
    executor : str
        Who computed.
    """

    command: str
    data: str
    hash: str
    seconds: float
    executor: str

    def lines(self) -> list[tuple[str, str]]:
        """Names and values, as the report prints them."""
        import scipy
        import sklearn

        return [
            ("command", self.command),
            ("data", self.data),
            ("hash", self.hash),
            ("duration", f"{self.seconds:.0f} s, kept results included ({self.executor})"),
            (
                "versions",
                f"rangeface {rangeface.__version__}, Python {platform.python_version()}, "
                f"numpy {np.__version__}, scipy {scipy.__version__}, "
                f"scikit-learn {sklearn.__version__}; {platform.system()} {platform.machine()}",
            ),
        ]


def publish(findings: Findings, folder: Path, provenance: Provenance) -> Path:
    """Write the report and its tables.

    Parameters
    ----------
    findings : Findings
    folder : Path
        Made if it is missing. Tables do not depend on when or how they were computed.
    provenance : Provenance
        Stands in the report only.

    Returns
    -------
    Path
        Of ``report.html``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tables, figures = [*findings.tables], [*findings.figures]
    if findings.verdicts:
        tables.insert(0, verdict_table(findings.verdicts))
    if findings.comparisons is not None:
        name, comparisons = findings.comparisons
        tables.append(rates_table(name, comparisons))
        figures.insert(0, (f"Scores of: {name}", png(score_figure(comparisons))))
        write_scores(folder / "scores.csv", comparisons)
    for table in tables:
        _write(folder / f"{table.name}.csv", as_csv(table))
        _write(folder / f"{table.name}.tex", as_latex(table))
    _write(folder / "tables.md", "\n\n".join(as_markdown(table) for table in tables) + "\n")
    for number, (_, picture) in enumerate(figures, start=1):
        (folder / f"figure-{number}.png").write_bytes(picture)
    report = folder / "report.html"
    page = _page(findings, tables, figures, provenance)
    page.write(report, provenance=provenance.command)
    return report


def _page(
    findings: Findings,
    tables: Sequence[Table],
    figures: Sequence[tuple[str, bytes]],
    provenance: Provenance,
) -> Report:
    page = Report(findings.title)
    page.text(findings.question)
    for table in tables:
        page.heading(table.caption)
        page.table(table.header, table.rows)
    if figures:
        page.heading("Pictures")
    for caption, picture in figures:
        page.picture(picture, caption)
    if findings.readings:
        page.heading("How the source was read, and what limits this")
        page.points(findings.readings)
    page.heading("Provenance")
    page.table(("what", "value"), provenance.lines())
    return page


def rates_table(name: str, comparisons: Comparisons) -> Table:
    """Every rate that a table of scores can show."""
    rows = [(which, str(rate)) for which, rate in comparisons.rates().items()]
    caption = f"Rates of: {name} (scores as they are, thresholds chosen on the same people)"
    return Table("rates", caption, ("rate", "value [95 %] (count)"), rows)


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """Verdicts as a table."""
    rows = [
        (
            v.source,
            v.text,
            f"{100 * v.difference:+.1f} [{100 * v.low:+.1f}, {100 * v.high:+.1f}]",
            f"{v.p:.4f}",
            v.verdict,
        )
        for v in verdicts
    ]
    caption = (
        "What was claimed, and whether it holds: paired permutation tests over people, "
        "p corrected by Holm's method for all claims of the same source, decided at 0.05"
    )
    header = ("who says so", "claim", "difference, points [95 %]", "p", "verdict")
    return Table("verdicts", caption, header, rows)


def as_csv(table: Table) -> str:
    """A table as CSV."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(table.header)
    writer.writerows([str(entry) for entry in row] for row in table.rows)
    return buffer.getvalue()


def as_markdown(table: Table) -> str:
    """A table as Markdown, its caption above it."""
    lines = [f"**{table.caption}**", ""]
    for row in (table.header, ["---"] * len(table.header), *table.rows):
        lines.append("| " + " | ".join(str(entry).replace("|", "\\|") for entry in row) + " |")
    return "\n".join(lines)


def as_latex(table: Table) -> str:
    """A table as LaTeX, for ``booktabs``."""
    body = [" & ".join(_tex(str(entry)) for entry in row) + r" \\" for row in table.rows]
    return "\n".join(
        [
            r"\begin{tabular}{" + "l" * len(table.header) + "}",
            r"\toprule",
            " & ".join(_tex(name) for name in table.header) + r" \\",
            r"\midrule",
            *body,
            r"\bottomrule",
            r"\end{tabular}",
            "% " + table.caption,
            "",
        ]
    )


_TEX = str.maketrans(
    {
        **{c: "\\" + c for c in "&%$#_{}"},
        "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
        "σ": r"$\sigma$", "α": r"$\alpha$", "π": r"$\pi$", "×": r"$\times$", "−": "$-$",
        "≥": r"$\ge$", "≤": r"$\le$", "°": r"$^\circ$",
    }
)  # fmt: skip


def _tex(text: str) -> str:
    return text.translate(_TEX)


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")
