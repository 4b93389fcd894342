"""Any history of operations leaves what a plain dictionary would hold."""

import tempfile
from concurrent.futures import ThreadPoolExecutor
from datetime import date

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from rangeface.errors import GalleryError
from rangeface.gallery import Consent, MemoryGallery, SqliteGallery
from rangeface.types import Template

NAMES = st.sampled_from(["ann", "bob", "cy", "dee"])
DAY = date(2026, 6, 1)


class Histories(RuleBasedStateMachine):
    """Two connections to one file, one gallery in memory, and a dictionary."""

    def __init__(self):
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        path = f"{self.folder.name}/g.db"
        self.galleries = [MemoryGallery(), SqliteGallery(path), SqliteGallery(path)]
        self.truth: dict[str, list[float]] = {}
        self.expired: set[str] = set()

    @rule(name=NAMES, value=st.integers(0, 99), writer=st.integers(1, 2), lapsed=st.booleans())
    def enroll(self, name, value, writer, lapsed):
        consent = Consent("C", date(2026, 5, 1)) if lapsed else None
        for gallery in (self.galleries[0], self.galleries[writer]):
            gallery.enroll(name, Template(([[float(value)]],), "f"), consent=consent)
        self.truth.setdefault(name, []).append(float(value))
        if lapsed:
            self.expired.add(name)

    @precondition(lambda self: self.truth)
    @rule(name=NAMES, writer=st.integers(1, 2))
    def delete(self, name, writer):
        for gallery in (self.galleries[0], self.galleries[writer]):
            if name in self.truth:
                assert gallery.delete(name) == len(self.truth[name])
            else:
                with pytest.raises(GalleryError):
                    gallery.delete(name)
        self.truth.pop(name, None)
        self.expired.discard(name)

    @rule(writer=st.integers(1, 2))
    def refuse(self, writer):
        with pytest.raises(GalleryError):
            self.galleries[writer].enroll("", Template(([[1.0]],), "f"))

    @invariant()
    def all_hold_the_same(self):
        searched = [name for name in self.truth if name not in self.expired]
        for gallery in self.galleries:
            view = gallery.view(today=DAY)
            assert gallery.subjects() == tuple(self.truth)
            assert list(view.subjects) == searched
            for number, name in enumerate(searched):
                rows = view.vectors[0][view.owners[0] == number].ravel()
                np.testing.assert_array_equal(rows, self.truth[name])

    def teardown(self):
        for gallery in self.galleries:
            gallery.close()
        self.folder.cleanup()


TestHistories = Histories.TestCase
TestHistories.settings = settings(max_examples=15, stateful_step_count=15, deadline=None)


def run_mixed(path, operations: int) -> None:
    """Threads that share one gallery and others with their own connection, all on one file."""
    shared = SqliteGallery(path)

    def work(number: int) -> dict[str, float]:
        rng = np.random.default_rng(number)
        gallery = shared if number % 2 else SqliteGallery(path)
        mine: dict[str, float] = {}
        for k in range(operations // 4):
            choice = rng.random()
            if choice < 0.3:
                value = float(rng.integers(1000))
                gallery.enroll(f"{number}-{k}", Template(([[value, number]],), "f"))
                mine[f"{number}-{k}"] = value
            elif choice < 0.4 and mine:
                name = str(rng.choice(list(mine)))
                assert gallery.delete(name) == 1
                del mine[name]
            else:
                view = gallery.view()
                seen = {
                    name: float(view.vectors[0][row, 0])
                    for row, name in enumerate(view.subjects)
                    if name.startswith(f"{number}-")
                }
                assert seen == mine
        if gallery is not shared:
            gallery.close()
        return mine

    with ThreadPoolExecutor(4) as pool:
        expected = {k: v for mine in pool.map(work, range(4)) for k, v in mine.items()}
    with shared:
        view = shared.view()
        assert dict(zip(view.subjects, view.vectors[0][:, 0].tolist(), strict=True)) == expected
        assert len(shared.audit()) >= len(expected)


def test_concurrent_operations_see_their_own_writes_and_lose_none(tmp_path):
    run_mixed(tmp_path / "g.db", 200)


@pytest.mark.slow
def test_ten_thousand_concurrent_operations(tmp_path):
    run_mixed(tmp_path / "g.db", 10_000)
