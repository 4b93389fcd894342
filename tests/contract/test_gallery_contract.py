"""Every gallery keeps the protocol."""

import sqlite3
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
from rangeface.gallery._record import digest, encode
from rangeface.gallery._schema import APPLICATION_ID, MIGRATIONS
from rangeface.gallery._vault import Vault
from rangeface.types import Assessment, Orthographic, RangeImage, Reason, Template

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


def old_file(path, version: int, vault: Vault | None = None) -> None:
    """A gallery as the first versions wrote it: names in the clear even beside sealed templates."""
    payload = encode(template(0)) if vault is None else vault.seal(encode(template(0)), "ann")
    person, record = digest("ann", "C-1", None), digest("ann", payload)
    seal = bytes(a ^ b for a, b in zip(person, record, strict=True))
    raw = sqlite3.connect(path)
    with raw:
        for statement in (s for step in MIGRATIONS[:version] for s in step):
            raw.execute(statement)
        raw.execute("INSERT INTO people VALUES (1, 'ann', 'C-1', NULL, ?)", (person,))
        raw.execute("INSERT INTO templates VALUES (1, 1, ?, ?)", (payload, record))
        raw.execute("UPDATE meta SET value = ? WHERE key = 'seal'", (seal,))
        if vault is not None:
            proof = vault.seal(b"rangeface gallery", "")
            raw.execute("INSERT INTO meta VALUES ('key proof', ?)", (proof,))
        raw.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        raw.execute(f"PRAGMA user_version = {version}")
    raw.close()


@pytest.mark.parametrize("version", [1, 2])
def test_a_gallery_of_an_older_version_is_brought_up_to_date(tmp_path, version):
    old_file(tmp_path / "g.db", version)
    with SqliteGallery(tmp_path / "g.db") as gallery:
        assert gallery.view().subjects == ("ann",)
        assert gallery.audit() == ()
        gallery.enroll("bob", template(1))
        assert [e.person for e in gallery.audit()] == [2]


def test_names_of_an_older_encrypted_gallery_are_sealed_when_it_is_opened(tmp_path):
    pytest.importorskip("cryptography")
    old_file(tmp_path / "g.db", 2, Vault(KEY))
    assert b"C-1" in (tmp_path / "g.db").read_bytes()
    for _ in range(2):
        with SqliteGallery(tmp_path / "g.db", key=KEY) as gallery:
            assert gallery.subjects() == ("ann",)
            assert gallery.consent("ann") == Consent("C-1")
            np.testing.assert_array_equal(
                gallery.templates("ann")[0].vectors[0], template(0).vectors[0]
            )
    assert b"C-1" not in (tmp_path / "g.db").read_bytes()
    assert b"ann" not in (tmp_path / "g.db").read_bytes()


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
        gallery.enroll("Annabel Lee", template(0, widths=(180,)), consent=Consent("C-7419"))
        gallery.enroll("bob", template(0, widths=(180,)))
    raw = (tmp_path / "g.db").read_bytes()
    plain = template(0, widths=(180,)).vectors[0].tobytes()
    assert not any(plain[i : i + 8] in raw for i in range(0, len(plain) - 8, 4))
    assert FINGERPRINT.encode() not in raw
    assert b"Annabel" not in raw
    assert b"C-7419" not in raw


def frontal(seed: int) -> RangeImage:
    depth = np.random.default_rng(seed).standard_normal((8, 5)).astype(np.float32)
    depth[0, 0] = np.nan
    return RangeImage(
        depth, Orthographic(2.8, 2.0, 4.0, 5, 8), sigma=np.abs(depth), filled=depth > 0.5
    )


def test_a_gallery_is_rebuilt_from_its_frontal_images(tmp_path):
    pytest.importorskip("cryptography")
    seen = []

    def make(image, assessment):
        seen.append((image, assessment))
        return Template((np.full((2, 4), len(seen)),), "g" * 64, assessment)

    with SqliteGallery(tmp_path / "g.db", key=KEY) as gallery:
        for seed, name in enumerate(["ann", "bob", "ann"]):
            gallery.enroll(name, template(seed), frontal=frontal(seed))
    with SqliteGallery(tmp_path / "g.db", key=KEY) as gallery:
        gallery.delete("bob")
        assert gallery.rebuild(make) == 2
        assert gallery.fingerprint == "g" * 64
        assert gallery.view().vectors[0][:, 0].tolist() == [1, 1, 2, 2]
        assert gallery.audit()[-1].action == "rebuilt"
        assert gallery.rebuild(make) == 2  # the images are still there
    for (image, _), seed in zip(seen, (0, 2, 0, 2), strict=True):
        expected = frontal(seed)
        assert image.camera == expected.camera
        np.testing.assert_array_equal(image.depth, expected.depth)
        np.testing.assert_array_equal(image.sigma, expected.sigma)
        np.testing.assert_array_equal(image.filled, expected.filled)
