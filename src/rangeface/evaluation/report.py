"""One self-contained HTML page: text, tables, pictures; no network, readable on paper."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

#: Tables of more columns are set smaller.
_WIDE = 7

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem;
       color: #1b1b1b; background: #fff; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.25rem; margin-top: 2.2rem; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { padding: .3rem .8rem; text-align: left; border-bottom: 1px solid #ccc; }
th { border-bottom: 2px solid #444; }
img { max-width: 100%; height: auto; display: block; }
figure { margin: 1rem 0; } figcaption { color: #555; font-size: .9rem; }
.scroll { overflow-x: auto; }
footer { margin-top: 3rem; color: #555; font-size: .85rem; }
table.wide { font-size: .85rem; } .wide th, .wide td { padding: .2rem .4rem; }
td small { color: #555; } td i { color: #777; }
@media (prefers-color-scheme: dark) {
  body { color: #e8e8e8; background: #161616; } th, td { border-color: #444; }
  figcaption, footer, td small, td i { color: #aaa; } img { background: #fff; }
}
@page { size: A4 landscape; margin: 12mm; }
@media print {
  html { font-size: 9pt; }
  body { font-size: 1rem; max-width: none; margin: 0; padding: 0; color: #000; background: #fff; }
  h2 { margin-top: 1.4rem; } footer { margin-top: 1rem; }
  th, td { padding: .1rem .3rem; } .scroll { overflow-x: visible; }
  td small, td i, figcaption, footer { color: #444; }
  figure, tr, h2 { break-inside: avoid; } h2 { break-after: avoid; }
  .scroll:not(:has(tr:nth-child(16))) { break-inside: avoid; }
  thead { display: table-header-group; } figure img { max-height: 165mm; }
}
"""


@dataclass
class Report:
    """A page that grows from top to bottom.

    Parameters
    ----------
    title : str
    """

    title: str
    _parts: list[str] = field(default_factory=list)

    def heading(self, text: str) -> None:
        """Begin a section."""
        self._parts.append(f"<h2>{escape(text)}</h2>")

    def text(self, text: str) -> None:
        """Add a paragraph."""
        self._parts.append(f"<p>{escape(text)}</p>")

    def points(self, texts: Sequence[str]) -> None:
        """Add a list of short paragraphs."""
        self._parts.append("<ul>" + "".join(f"<li>{escape(t)}</li>" for t in texts) + "</ul>")

    def table(self, header: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        """Add a table; cells are printed as they are, or as they draw themselves in HTML."""
        head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
        body = "".join(
            "<tr>" + "".join(f"<td>{_html(cell)}</td>" for cell in row) + "</tr>" for row in rows
        )
        width = ' class="wide"' if len(header) > _WIDE else ""
        table = f"<table{width}><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        self._parts.append(f'<div class="scroll">{table}</div>')

    def picture(self, png: bytes, caption: str) -> None:
        """Add a PNG with its caption."""
        data = base64.b64encode(png).decode()
        self._parts.append(
            f'<figure><img alt="{escape(caption)}" src="data:image/png;base64,{data}">'
            f"<figcaption>{escape(caption)}</figcaption></figure>"
        )

    def write(self, path: Path, *, provenance: str) -> None:
        """Write the page.

        Parameters
        ----------
        path : Path
        provenance : str
            Versions, seed and command, at its foot.
        """
        page = (
            f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{escape(self.title)}</title><style>{_STYLE}</style></head><body>"
            f"<h1>{escape(self.title)}</h1>{''.join(self._parts)}"
            f"<footer>{escape(provenance)}</footer></body></html>\n"
        )
        path.write_text(page, encoding="utf-8")


def _html(cell: object) -> str:
    draw = getattr(cell, "_repr_html_", None)
    return escape(str(cell)) if draw is None else str(draw())
