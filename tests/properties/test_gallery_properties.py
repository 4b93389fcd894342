"""Any history of operations leaves what a plain dictionary would hold."""

import tempfile
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
