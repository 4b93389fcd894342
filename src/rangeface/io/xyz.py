"""Points as text: one a line, x y z first (``.xyz``, ``.asc``, ``.txt``, ``.csv``, ``.pts``).

Blanks, tabs, commas or semicolons separate; ``#`` and ``//`` begin a comment, one line of
titles or of a point count may come first, further columns are passed over. The unit is mm, y
up, z towards the viewer, unless the caller says otherwise.
"""

from __future__ import annotations

import re

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud
from rangeface.io._source import Source
from rangeface.numerics.lines import count_rows, read_table

_NUMBER = rb"[-+]?(?:\d++(?:\.\d*+)?+|\.\d++)(?:[eE][-+]?\d++)?+|[-+]?[nN][aA][nN]"
_POINT = re.compile(rb"[ \t]*(?:%s)(?:[ \t]*[,;][ \t]*|[ \t]+)(?:%s)(?:[ \t]*[,;][ \t]*|[ \t]+)"
                    rb"(?:%s)(?=[\s,;]|$)" % ((_NUMBER,) * 3))  # fmt: skip
_TITLE = re.compile(
    rb"(?:[ \t]*+(?://|#|[\"A-Za-z]|\d++[ \t]*+[\r\n])[^\r\n]*+[\r\n]*+|[ \t]*+[\r\n]++){0,64}+"
)


def recognise(source: Source) -> bool:
    """Three numbers on a line, after titles, in a file without NUL."""
    head = source.data[:8192]
    return b"\0" not in head and _start(head) >= 0


def parse(source: Source) -> Cloud:
    """The first three columns."""
    start = _start(source.data[:8192])
    text = source.array
    rows = count_rows(text, start)
    source.cap_points(rows)
    points, stop = read_table(text, start, rows, 3)
    if len(points) < rows:
        line = 1 + source.data.count(b"\n", 0, stop)
        raise source.error(ScanFault.MALFORMED, f"line {line} holds no three numbers")
    return Cloud(points)


def _start(head: bytes) -> int:
    """Offset of the first point, −1 where there is none."""
    titles = _TITLE.match(head)
    at = titles.end() if titles else 0
    return at if _POINT.match(head, at) else -1
