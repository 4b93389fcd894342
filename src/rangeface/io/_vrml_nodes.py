"""The words of a VRML file → a tree of nodes, number lists through the fast scanner.

The grammar needs no list of node types: a word before a brace opens a node, any other word is
the name of the field that the values behind it belong to.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._source import Source
from rangeface.numerics.text import numbers

_TOKEN = re.compile(
    rb"""(?:[\s,]++|\#[^\r\n]*+)*+              # white space, commas and comments
    (?: (?P<number>[-+]?\.?\d[^\s,{}\[\]\#"]*+)
      | (?P<word>[^\s,{}\[\]\#"]++)
      | (?P<mark>[{}\[\]])
      | (?P<text>"(?:[^"\\]|\\.)*+") )""",
    re.VERBOSE | re.DOTALL,
)
_MAX_TOKENS = 100_000  # outside of number lists; a scan has a few hundred


@dataclass
class Node:
    kind: str
    values: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    children: list[Node] = field(default_factory=list)

    def value(self, name: str, default: tuple[float, ...]) -> NDArray[np.float64]:
        """Numbers of a field, the default where it is absent or too short."""
        found = self.values.get(name, np.empty(0))[: len(default)]
        return found if len(found) == len(default) else np.array(default)


class Parser:
    """Tokens → nodes; number lists go through the fast scanner."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.text = source.array
        self.at = 0
        self.left = _MAX_TOKENS
        self.named: dict[bytes, Node] = {}

    def scene(self) -> list[Node]:
        """The nodes at the top of the file."""
        top = Node("")
        while (token := self.token()) is not None:
            self.item(top, token, "", 0)
        return top.children

    def token(self) -> re.Match[bytes] | None:
        """The next token; None at the end."""
        self.left -= 1
        if self.left < 0:
            raise self.source.error(ScanFault.TOO_LARGE, f"more than {_MAX_TOKENS} words")
        found = _TOKEN.match(self.source.data, self.at)
        if found is not None:
            self.at = found.end()
        elif self.source.data.find(b'"', self.at) >= 0:
            raise self.source.error(ScanFault.TRUNCATED, "a text has no end")
        return found

    def need(self, what: str) -> re.Match[bytes]:
        """The next token, which must exist."""
        token = self.token()
        if token is None:
            raise self.source.error(ScanFault.TRUNCATED, f"the file ends in {what}")
        return token

    def word(self, what: str) -> bytes:
        token = self.need(what)
        if token["word"] is None:
            raise self.source.error(ScanFault.MALFORMED, f"{token[0].strip()[:20]!r} in {what}")
        return token["word"]

    def item(self, owner: Node, token: re.Match[bytes], name: str, depth: int) -> str:
        """One thing in a node's body or a list; the field name that holds from here on."""
        if token["number"] is not None:
            self.scalars(owner, token, name)
        elif token["mark"] == b"[":
            self.list(owner, name, depth)
        elif token["mark"] is not None:
            raise self.source.error(ScanFault.MALFORMED, f"{token['mark'].decode()} out of place")
        elif token["word"] is not None:
            return self.named_item(owner, token["word"], depth)
        return name

    def named_item(self, owner: Node, word: bytes, depth: int) -> str:
        if word == b"USE":
            name = self.word("USE")
            if name in self.named:  # names of materials and the like may be unknown to us
                owner.children.append(self.named[name])
        elif word == b"DEF":
            name = self.word("DEF")
            node = self.node(self.word("DEF"), depth)
            self.named[name] = node
            owner.children.append(node)
        elif word in (b"PROTO", b"EXTERNPROTO"):
            self.prototype(word, depth)
        elif self.opens():
            owner.children.append(self.node(word, depth))
        else:
            return word.decode("latin-1")
        return ""

    def opens(self) -> bool:
        """Whether the next token is an opening brace."""
        found = _TOKEN.match(self.source.data, self.at)
        return found is not None and found["mark"] == b"{"

    def node(self, kind: bytes, depth: int) -> Node:
        """A node, from its opening to its closing brace."""
        if depth >= self.source.limits.max_nesting:
            raise self.source.error(
                ScanFault.TOO_LARGE, f"nested deeper than {self.source.limits.max_nesting}"
            )
        if self.need(f"node {kind.decode('latin-1')}")["mark"] != b"{":
            raise self.source.error(ScanFault.MALFORMED, f"no {{ after {kind[:40]!r}")
        node = Node(kind.decode("latin-1"))
        name = ""
        while (token := self.need(f"node {node.kind}"))["mark"] != b"}":
            name = self.item(node, token, name, depth + 1)
        return node

    def scalars(self, owner: Node, token: re.Match[bytes], name: str) -> None:
        """Numbers that stand free after a field name."""
        start = token.start("number")
        values, stop = numbers(self.text, start, 16, commas=True)
        if len(values):  # else something like 3dsmax that only looks like a number
            self.at = stop
            owner.values.setdefault(name, values)

    def list(self, owner: Node, name: str, depth: int) -> None:
        """What stands in brackets: numbers, or nodes and texts."""
        data = self.source.data
        end = data.find(b"]", self.at)
        if end < 0:
            raise self.source.error(ScanFault.TRUNCATED, f"list {name} has no end")
        values, stop = self.numbers_until(end)
        if stop > end and data[stop : stop + 1] != b"]":  # that bracket stood in a comment
            values, stop = self.numbers_until(len(data))
        if data[stop : stop + 1] == b"]":
            self.at = stop + 1
            owner.values.setdefault(name, values)
            return
        if len(values):
            bad = bytes(self.source.data[stop : stop + 12])
            raise self.source.error(ScanFault.MALFORMED, f"{bad!r} in the numbers of {name}")
        if depth >= self.source.limits.max_nesting:
            raise self.source.error(ScanFault.TOO_LARGE, "lists nested too deeply")
        while (token := self.need(f"list {name}"))["mark"] != b"]":
            self.item(owner, token, name, depth + 1)

    def numbers_until(self, end: int) -> tuple[NDArray[np.float64], int]:
        """As many numbers as can stand before an offset."""
        most = min((end - self.at) // 2 + 1, 6 * self.source.limits.max_points)
        return numbers(self.text, self.at, most, commas=True)

    def prototype(self, word: bytes, depth: int) -> None:
        """Pass over the definition of a node type."""
        self.word("PROTO")
        hidden = Node("")
        self.item(hidden, self.need("PROTO"), "", depth + 1)
        if word == b"PROTO":
            self.node(word, depth + 1)
