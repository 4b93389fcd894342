"""Every gallery keeps the protocol."""

from datetime import date
from itertools import pairwise

import numpy as np
import pytest

from rangeface.errors import GalleryError
from rangeface.gallery import (
    Consent,
    MemoryGallery,
    SqliteGallery,
    export_gallery,
    import_gallery,
    open_gallery,
    read_key,
)
from rangeface.types import Assessment, Reason, Template

FINGERPRINT = "f" * 64


def template(seed: int, fingerprint: str = FINGERPRINT, widths: tuple[int, ...] = (5, 3)):
    rng = np.random.default_rng(seed)
    views = 1 + seed % 3
    vectors = tuple(rng.standard_normal((views, w)).astype(np.float32) for w in widths)
    return Template(vectors, fingerprint)


KEY = bytes(range(32))


@pytest.fixture(params=["memory", "sqlite", "encrypted"])
def gallery(request, tmp_path):
    if request.param == "encrypted":
        pytest.importorskip("cryptography")
    opened = {
        "memory": MemoryGallery,
        "sqlite": lambda: SqliteGallery(tmp_path / "g.db"),
        "encrypted": lambda: SqliteGallery(tmp_path / "g.db", key=KEY),
    }[request.param]()
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


def test_many_are_enrolled_together_or_not_at_all(gallery):
    gallery.enroll_many([("ann", template(0), Consent("C")), ("bob", template(1), None)])
    assert gallery.subjects() == ("ann", "bob")
    with pytest.raises(GalleryError, match="enrol everybody again"):
        gallery.enroll_many([("cy", template(2), None), ("dee", template(3, "g" * 64), None)])
    assert gallery.subjects() == gallery.view().subjects == ("ann", "bob")
    gallery.enroll("cy", template(2))
    assert len(gallery.view().subjects) == 3


def test_the_log_says_what_was_done_to_whom_without_names(gallery):
    gallery.enroll("ann", template(0))
    gallery.enroll("bob", template(1), consent=Consent("C"))
    gallery.enroll("ann", template(2))
    gallery.delete("ann")
    gallery.enroll("ann", template(0))
    gallery.note("looked at")
    entries = gallery.audit()
    assert [(e.action, e.person) for e in entries] == [
        ("enrolled", 1),
        ("enrolled", 2),
        ("enrolled", 1),
        ("deleted", 1),
        ("enrolled", 3),  # a number is never used again
        ("looked at", 0),
    ]
    assert all(a.at <= b.at for a, b in pairwise(entries))


def test_what_is_exported_can_be_imported(gallery, tmp_path):
    gallery.enroll("ann", template(0), consent=Consent("C-1", date(2026, 3, 1)))
    gallery.enroll("bob", template(1), consent=Consent("C-2"))
    gallery.enroll("ann", template(2))
    assert export_gallery(gallery, tmp_path / "all.rfa") == 2
    for other in (MemoryGallery(), SqliteGallery(tmp_path / "other.db")):
        with other:
            assert import_gallery(other, tmp_path / "all.rfa") == 2
            assert other.subjects() == gallery.subjects()
            assert other.fingerprint == gallery.fingerprint
            for name in ("ann", "bob"):
                assert other.consent(name) == gallery.consent(name)
                for a, b in zip(other.templates(name), gallery.templates(name), strict=True):
                    for v, w in zip(a.vectors, b.vectors, strict=True):
                        np.testing.assert_array_equal(v, w)
            with pytest.raises(GalleryError, match="'ann' is enrolled already"):
                import_gallery(other, tmp_path / "all.rfa")


@pytest.mark.parametrize("key", [None, KEY])
def test_a_backup_is_a_gallery_and_can_be_copied_back(tmp_path, key):
    if key:
        pytest.importorskip("cryptography")
    with SqliteGallery(tmp_path / "g.db", key=key) as gallery:
        gallery.enroll("ann", template(0))
        gallery.backup(tmp_path / "copy.db")
        gallery.enroll("bob", template(1))
        with SqliteGallery(tmp_path / "copy.db", create=False, key=key) as copy:
            assert copy.view().subjects == ("ann",)
            assert copy.audit() == gallery.audit()[:-1]
            copy.backup(tmp_path / "g.db", overwrite=True)
        # one who has the gallery open sees what was restored
        assert gallery.view().subjects == ("ann",)
        gallery.enroll("cy", template(2))
        assert gallery.view().subjects == ("ann", "cy")


def test_a_gallery_of_the_first_version_is_brought_up_to_date(tmp_path, monkeypatch):
    from rangeface.gallery import _schema, _sqlite

    with monkeypatch.context() as past:
        past.setattr(_schema, "MIGRATIONS", _schema.MIGRATIONS[:1])
        past.setattr(_sqlite._audit, "note", lambda *_: None)
        with SqliteGallery(tmp_path / "g.db") as old:
            old.enroll("ann", template(0))
    with SqliteGallery(tmp_path / "g.db") as gallery:
        assert gallery.view().subjects == ("ann",)
        assert gallery.audit() == ()
        gallery.enroll("bob", template(1))
        assert [e.person for e in gallery.audit()] == [2]


def test_a_key_comes_from_the_environment_or_a_file(tmp_path, monkeypatch):
    pytest.importorskip("cryptography")
    assert read_key({}) is None
    (tmp_path / "key").write_text("AAECAwQFBgcICQoLDA0ODxAREhMUFRYXGBkaGxwdHh8=\n")
    assert read_key({"RANGEFACE_GALLERY_KEY_FILE": str(tmp_path / "key")}) == KEY
    monkeypatch.setenv("RANGEFACE_GALLERY_KEY", KEY.hex())
    with open_gallery(tmp_path / "g.db") as gallery:
        gallery.enroll("ann", template(0))
    monkeypatch.delenv("RANGEFACE_GALLERY_KEY")
    with open_gallery(tmp_path / "g.db", key=KEY) as gallery:
        assert gallery.view().subjects == ("ann",)


def test_an_encrypted_file_holds_no_run_of_a_template(tmp_path):
    pytest.importorskip("cryptography")
    with SqliteGallery(tmp_path / "g.db", key=KEY) as gallery:
        gallery.enroll("ann", template(0, widths=(180,)))
        gallery.enroll("bob", template(0, widths=(180,)))
    raw = (tmp_path / "g.db").read_bytes()
    plain = template(0, widths=(180,)).vectors[0].tobytes()
    assert not any(plain[i : i + 8] in raw for i in range(0, len(plain) - 8, 4))
    assert FINGERPRINT.encode() not in raw
