"""Every gallery keeps the protocol."""

from datetime import date

import numpy as np
import pytest

from rangeface.errors import GalleryError
from rangeface.gallery import Consent, MemoryGallery, SqliteGallery, open_gallery
from rangeface.types import Assessment, Reason, Template

FINGERPRINT = "f" * 64


def template(seed: int, fingerprint: str = FINGERPRINT, widths: tuple[int, ...] = (5, 3)):
    rng = np.random.default_rng(seed)
    views = 1 + seed % 3
    vectors = tuple(rng.standard_normal((views, w)).astype(np.float32) for w in widths)
    return Template(vectors, fingerprint)


@pytest.fixture(params=["memory", "sqlite"])
def gallery(request, tmp_path):
    opened = MemoryGallery() if request.param == "memory" else SqliteGallery(tmp_path / "g.db")
    with opened:
        yield opened


def test_a_new_gallery_is_empty(gallery):
    view = gallery.view()
    assert gallery.subjects() == view.subjects == view.vectors == ()
    assert gallery.fingerprint is view.fingerprint is None


def test_what_is_enrolled_is_found_again(gallery):
    for seed, name in enumerate(["ann", "bob", "ann"]):
        gallery.enroll(name, template(seed))
    assert gallery.subjects() == ("ann", "bob")
    assert gallery.fingerprint == FINGERPRINT
    view = gallery.view()
    assert [o.tolist() for o in view.owners] == [[0, 1, 1, 0, 0, 0]] * 2
    for head in range(2):
        expected = np.concatenate([template(seed).vectors[head] for seed in range(3)])
        np.testing.assert_array_equal(view.vectors[head], expected)
    assert len(gallery.templates("ann")) == 2


def test_the_view_is_the_same_object_until_something_changes(gallery):
    gallery.enroll("ann", template(0))
    first = gallery.view()
    assert gallery.view() is first
    gallery.enroll("bob", template(1))
    assert gallery.view().subjects == ("ann", "bob")
    assert first.subjects == ("ann",)


def test_a_view_cannot_be_written_to(gallery):
    gallery.enroll("ann", template(0))
    with pytest.raises(ValueError, match="read-only"):
        gallery.view().vectors[0][0, 0] = 1.0


def test_the_assessment_comes_back(gallery):
    seen = Assessment(1, 2, 3, 0.9, 0.8, 1.5, 400, 2.0, 0.95, (Reason.POSE, Reason.TOO_NOISY))
    gallery.enroll("ann", Template(template(0).vectors, FINGERPRINT, seen))
    assert gallery.templates("ann")[0].assessment == seen


def test_delete_removes_one_person_only(gallery):
    for seed, name in enumerate(["ann", "bob", "ann"]):
        gallery.enroll(name, template(seed))
    assert gallery.delete("ann") == 2
    assert gallery.subjects() == gallery.view().subjects == ("bob",)
    with pytest.raises(GalleryError, match="'ann' is not enrolled"):
        gallery.templates("ann")


def test_an_emptied_gallery_takes_another_model(gallery):
    gallery.enroll("ann", template(0))
    gallery.delete("ann")
    gallery.enroll("ann", template(0, "g" * 64, (7,)))
    assert gallery.fingerprint == "g" * 64


def test_another_model_is_refused_with_the_way_out(gallery):
    gallery.enroll("ann", template(0))
    with pytest.raises(GalleryError, match="enrol everybody again"):
        gallery.enroll("bob", template(1, "g" * 64))
    assert gallery.subjects() == ("ann",)


def test_an_expired_person_is_listed_but_not_searched(gallery):
    gallery.enroll("ann", template(0), consent=Consent("C-1", date(2026, 3, 1)))
    gallery.enroll("bob", template(1))
    assert gallery.view(today=date(2026, 3, 1)).subjects == ("ann", "bob")
    assert gallery.view(today=date(2026, 3, 2)).subjects == ("bob",)
    assert gallery.subjects() == ("ann", "bob")
    assert gallery.consent("ann") == Consent("C-1", date(2026, 3, 1))
    assert gallery.consent("bob") is None


def test_a_new_consent_replaces_the_old_and_none_keeps_it(gallery):
    gallery.enroll("ann", template(0), consent=Consent("C-1", date(2026, 3, 1)))
    gallery.enroll("ann", template(1))
    assert gallery.consent("ann") == Consent("C-1", date(2026, 3, 1))
    gallery.enroll("ann", template(2), consent=Consent("C-2"))
    assert gallery.consent("ann") == Consent("C-2")
    assert len(gallery.view(today=date(2030, 1, 1)).subjects) == 1


def test_addresses(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert isinstance(open_gallery("memory://"), MemoryGallery)
    for address in ("sqlite:///a.db", f"sqlite:///{tmp_path}/b.db", tmp_path / "c.db"):
        with open_gallery(address) as opened:
            assert isinstance(opened, SqliteGallery)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.db", "b.db", "c.db"]


def test_two_connections_see_each_other(tmp_path):
    with SqliteGallery(tmp_path / "g.db") as one, SqliteGallery(tmp_path / "g.db") as two:
        one.enroll("ann", template(0))
        assert two.view().subjects == ("ann",)
        two.enroll("bob", template(1))
        assert one.view().subjects == ("ann", "bob")
        two.delete("ann")
        assert one.view().subjects == ("bob",)
