"""The gallery: exact search, enrolment, and what a change costs."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

import numpy as np

from rangeface.decide import per_subject
from rangeface.gallery import SqliteGallery, stack
from rangeface.numerics.similarity import similarity
from rangeface.types import Template

Arms = dict[str, Callable[[], object]]
_FINGERPRINT = "f" * 64


def stages() -> Iterator[tuple[str, str, Arms]]:
    rng = np.random.default_rng(0)
    for people in (10_000, 100_000):
        records = _records(rng, people, views=1)
        view = stack(records, _FINGERPRINT)
        probe = rng.standard_normal((1, 180), dtype=np.float32)
        G, owners = view.vectors[0], view.owners[0]
        squares = np.einsum("ij,ij->i", G, G)
        yield "exact search, 1 thread", f"{people}×180", {
            "ours": lambda p=probe, G=G: similarity(p, G),
            "ours, best of each person": lambda p=probe, G=G, o=owners, n=people: per_subject(
                similarity(p, G)[0], o, count=n
            ),
            "BLAS": lambda p=probe, G=G, s=squares: 2 * (G @ p[0]) - s,
        }  # fmt: skip
    yield from _file(rng, people=2_000)


def _file(rng: np.random.Generator, people: int) -> Iterator[tuple[str, str, Arms]]:
    records = _records(rng, people, views=13)
    number = count()
    with tempfile.TemporaryDirectory() as folder:
        gallery = SqliteGallery(Path(folder) / "g.db")
        gallery.enroll_many((s, t, None) for s, t in records)
        template = records[0][1]

        def enroll_and_view() -> object:
            gallery.enroll(f"new {next(number)}", template)
            return gallery.view()

        def reopen() -> object:
            with SqliteGallery(Path(folder) / "g.db") as other:
                return other.view()

        yield "gallery file", f"{people} people × 13 × 180", {
            "ours, view unchanged": gallery.view,
            "ours, enrol durably and view": enroll_and_view,
            "ours, open and view": reopen,
        }  # fmt: skip
        gallery.close()


def _records(rng: np.random.Generator, people: int, views: int) -> list[tuple[str, Template]]:
    vectors = rng.standard_normal((people, views, 180), dtype=np.float32)
    return [(f"p{i}", Template((v,), _FINGERPRINT)) for i, v in enumerate(vectors)]
