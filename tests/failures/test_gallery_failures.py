"""What a gallery refuses, and what it survives."""

import builtins
import os
import signal
import sqlite3
import subprocess
import sys
import textwrap

import numpy as np
import pytest

from rangeface.errors import GalleryError
from rangeface.gallery import (
    MemoryGallery,
    SqliteGallery,
    export_gallery,
    import_gallery,
    open_gallery,
    read_key,
)
from rangeface.gallery._schema import MIGRATIONS
from rangeface.io.arrays import write_arrays
from rangeface.types import Orthographic, RangeImage, Template

WRITER = textwrap.dedent(
    """
    import sys
    import numpy as np
    from rangeface.gallery import SqliteGallery
    from rangeface.types import Template

    path, cycle = sys.argv[1], int(sys.argv[2])
    rng = np.random.default_rng(cycle)
    with SqliteGallery(path) as gallery:
        for i in range(100_000):
            vectors = (rng.standard_normal((13, 180)).astype(np.float32),)
            gallery.enroll(f"p{cycle}-{i}", Template(vectors, "f" * 64))
            print(f"+p{cycle}-{i}", flush=True)
            if i % 3 == 2:
                gallery.delete(f"p{cycle}-{i - 1}")
                print(f"-p{cycle}-{i - 1}", flush=True)
    """
)


def template(seed: int = 0, width: int = 180, fingerprint: str = "f" * 64) -> Template:
    rng = np.random.default_rng(seed)
    return Template((rng.standard_normal((2, width)).astype(np.float32),), fingerprint)


# ── crashes ──────────────────────────────────────────────────────────────────────────────


def kill_cycles(path, cycles: int, rng: np.random.Generator) -> None:
    """Kill a writer in mid-write; whatever it acknowledged must be there, and nothing else."""
    expected: set[str] = set()
    for cycle in range(cycles):
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(path), str(cycle)],
            stdout=subprocess.PIPE,
            text=True,
        )
        wanted = int(rng.integers(1, 20))
        lines = [writer.stdout.readline().strip() for _ in range(wanted)]
        os.kill(writer.pid, signal.SIGKILL)
        lines += [line.strip() for line in writer.stdout if line.endswith("\n")]
        writer.stdout.close()
        writer.wait()
        for line in lines:
            (expected.add if line[0] == "+" else expected.discard)(line[1:])
        with SqliteGallery(path) as gallery:
            found = set(gallery.view().subjects)
        # the one operation in flight may have been done without being acknowledged
        assert len(found ^ expected) <= 1, (cycle, found ^ expected)
        expected = found


def test_kill_9_loses_nothing_acknowledged(tmp_path):
    kill_cycles(tmp_path / "g.db", 3, np.random.default_rng(0))


@pytest.mark.slow
def test_kill_9_fifty_times_loses_nothing_acknowledged(tmp_path):
    kill_cycles(tmp_path / "g.db", 50, np.random.default_rng(1))


# ── traces and damage ────────────────────────────────────────────────────────────────────


def runs(data: bytes) -> set[bytes]:
    return {data[i : i + 16] for i in range(len(data) - 15)}


@pytest.mark.parametrize("width", [9, 180, 3000])
def test_delete_leaves_no_16_bytes_of_a_template(tmp_path, width):
    rng = np.random.default_rng(width)
    with SqliteGallery(tmp_path / "g.db") as gallery:
        alive: dict[str, Template] = {}
        gone: list[Template] = []
        for i in range(60):
            gallery.enroll(f"p{i}", alive.setdefault(f"p{i}", template(i, width)))
            if rng.random() < 0.5:
                name = str(rng.choice(list(alive)))
                gallery.delete(name)
                gone.append(alive.pop(name))
        for name in alive:
            gallery.delete(name)
        gone += alive.values()
    traces = set().union(*(runs(v.tobytes()) for t in gone for v in t.vectors))
    for file in tmp_path.iterdir():
        assert not traces & runs(file.read_bytes()), file.name


def test_a_flipped_byte_never_changes_an_answer(tmp_path):
    path = tmp_path / "g.db"
    with SqliteGallery(path) as gallery:
        for i in range(6):
            gallery.enroll(f"person-{i}", template(i, 60))
        intact = gallery.view()
    sound = path.read_bytes()
    rng = np.random.default_rng(0)
    noticed = 0
    for place in rng.choice(len(sound), 400, replace=False):
        damaged = bytearray(sound)
        damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        try:
            with SqliteGallery(path, create=False) as gallery:
                view = gallery.view()
        except GalleryError:
            noticed += 1
            continue
        assert view.subjects == intact.subjects
        assert view.fingerprint == intact.fingerprint
        np.testing.assert_array_equal(view.vectors[0], intact.vectors[0])
    assert noticed > 30


@pytest.mark.parametrize(
    ("statement", "complaint"),
    [
        ("UPDATE templates SET payload = zeroblob(99) WHERE id = 1", "a record was altered"),
        ("UPDATE people SET name = 'eve' WHERE id = 1", "a record was altered"),
        ("UPDATE templates SET person = 3 - person", "a record was altered"),
        ("DELETE FROM templates WHERE id = 2", "records are missing"),
        ("DELETE FROM meta", "a row is missing"),
        ("UPDATE meta SET value = x'00'", "the seal is broken"),
    ],
)
def test_tampering_is_noticed(tmp_path, statement, complaint):
    with SqliteGallery(tmp_path / "g.db") as gallery:
        gallery.enroll("ann", template(1))
        gallery.enroll("bob", template(2))
    raw = sqlite3.connect(tmp_path / "g.db")
    with raw:
        raw.execute(statement)
    raw.close()
    with (
        SqliteGallery(tmp_path / "g.db") as gallery,
        pytest.raises(GalleryError, match=complaint),
    ):
        gallery.view()


# ── refusals ─────────────────────────────────────────────────────────────────────────────


def test_a_missing_file_is_not_made_unless_asked(tmp_path):
    with pytest.raises(GalleryError, match="no such gallery"):
        open_gallery(tmp_path / "none.db", create=False)
    with pytest.raises(GalleryError, match="unable to open"):
        open_gallery(tmp_path / "none" / "g.db")


def test_unknown_address():
    with pytest.raises(GalleryError, match="unknown gallery"):
        open_gallery("postgres://host/db")


def test_a_file_that_is_no_gallery(tmp_path):
    (tmp_path / "g.db").write_bytes(b"not a database, but long enough to look at" * 50)
    with pytest.raises(GalleryError, match="not a database"):
        open_gallery(tmp_path / "g.db")
    other = sqlite3.connect(tmp_path / "other.db")
    other.execute("CREATE TABLE t (x)")
    other.close()
    with pytest.raises(GalleryError, match="but no gallery"):
        open_gallery(tmp_path / "other.db")


def test_a_newer_version_is_refused(tmp_path):
    SqliteGallery(tmp_path / "g.db").close()
    raw = sqlite3.connect(tmp_path / "g.db")
    raw.execute(f"PRAGMA user_version = {len(MIGRATIONS) + 1}")
    raw.close()
    with pytest.raises(GalleryError, match="newer rangeface"):
        open_gallery(tmp_path / "g.db")


def test_a_full_disk_is_one_clear_line_and_loses_nothing(tmp_path):
    with SqliteGallery(tmp_path / "g.db") as gallery:
        gallery.enroll("ann", template(0))
        pages = gallery._db.one("PRAGMA page_count")[0]
        gallery._db.run(f"PRAGMA max_page_count = {pages}")
        with pytest.raises(GalleryError, match="full"):
            gallery.enroll("bob", template(1, width=3000))
        assert gallery.view().subjects == ("ann",)


def test_a_commit_that_fails_is_forgotten(tmp_path):
    with SqliteGallery(tmp_path / "g.db", timeout_s=0.05) as gallery:
        gallery.enroll("ann", template(0))
        reader = sqlite3.connect(tmp_path / "g.db", isolation_level=None)
        reader.execute("BEGIN")
        reader.execute("SELECT * FROM people").fetchone()  # a shared lock stops the commit only
        with pytest.raises(GalleryError, match="locked"):
            gallery.enroll("bob", template(1))
        reader.close()
        assert gallery.subjects() == gallery.view().subjects == ("ann",)
        gallery.enroll("cy", template(2))
        assert gallery.view().subjects == ("ann", "cy")


def test_a_locked_file_is_one_clear_line(tmp_path):
    with SqliteGallery(tmp_path / "g.db", timeout_s=0.05) as gallery:
        other = sqlite3.connect(tmp_path / "g.db")
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(GalleryError, match="locked"):
            gallery.enroll("ann", template(0))
        other.close()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write to read-only files")
def test_a_read_only_file_is_one_clear_line(tmp_path):
    with SqliteGallery(tmp_path / "g.db") as gallery:
        gallery.enroll("ann", template(0))
    (tmp_path / "g.db").chmod(0o444)
    with (
        SqliteGallery(tmp_path / "g.db") as gallery,
        pytest.raises(GalleryError, match="readonly"),
    ):
        gallery.enroll("bob", template(1))


@pytest.mark.parametrize("kind", [MemoryGallery, SqliteGallery])
@pytest.mark.parametrize(
    ("bad", "complaint"),
    [
        (Template((), "f" * 64), "for each head"),
        (Template((np.zeros((0, 5)),), "f" * 64), "for each head"),
        (Template((np.zeros(5),), "f" * 64), "for each head"),
        (Template((np.full((1, 5), np.nan),), "f" * 64), "finite"),
        (template(0, width=7), "does not fit"),
    ],
)
def test_a_template_of_the_wrong_shape_is_refused(tmp_path, kind, bad, complaint):
    with kind() if kind is MemoryGallery else kind(tmp_path / "g.db") as gallery:
        gallery.enroll("ann", template(0))
        with pytest.raises(GalleryError, match=complaint):
            gallery.enroll("bob", bad)
        assert gallery.subjects() == ("ann",)


@pytest.mark.parametrize("kind", [MemoryGallery, SqliteGallery])
@pytest.mark.parametrize("name", ["", "a\nb", "x" * 201])
def test_a_bad_name_is_refused(tmp_path, kind, name):
    with kind() if kind is MemoryGallery else kind(tmp_path / "g.db") as gallery:
        with pytest.raises(GalleryError, match="subject"):
            gallery.enroll(name, template(0))
        assert gallery.subjects() == ()


@pytest.mark.parametrize("kind", [MemoryGallery, SqliteGallery])
@pytest.mark.parametrize("verb", ["delete", "consent", "templates"])
def test_an_unknown_person(tmp_path, kind, verb):
    with (
        kind() if kind is MemoryGallery else kind(tmp_path / "g.db") as gallery,
        pytest.raises(GalleryError, match="not enrolled"),
    ):
        getattr(gallery, verb)("nobody")


# ── keys ─────────────────────────────────────────────────────────────────────────────────

KEY, OTHER = bytes(32), bytes([1] * 32)


def test_a_wrong_or_missing_key_is_one_clear_line(tmp_path):
    pytest.importorskip("cryptography")
    with SqliteGallery(tmp_path / "g.db", key=KEY) as gallery:
        gallery.enroll("ann", template(0))
    with pytest.raises(GalleryError, match="wrong key"):
        SqliteGallery(tmp_path / "g.db", key=OTHER)
    with pytest.raises(GalleryError, match="is encrypted; give its key"):
        SqliteGallery(tmp_path / "g.db")
    with pytest.raises(GalleryError, match="32 bytes"):
        SqliteGallery(tmp_path / "g.db", key=b"short")


def test_a_plain_gallery_is_not_encrypted_by_giving_a_key(tmp_path):
    pytest.importorskip("cryptography")
    SqliteGallery(tmp_path / "g.db").close()
    with pytest.raises(GalleryError, match="is not encrypted; export"):
        SqliteGallery(tmp_path / "g.db", key=KEY)


def test_records_cannot_change_names_even_with_new_digests(tmp_path):
    pytest.importorskip("cryptography")
    from rangeface.gallery._vault import Vault

    vault = Vault(KEY)
    with pytest.raises(GalleryError, match="altered"):
        vault.open(vault.seal(b"template", "ann"), "bob")
    with pytest.raises(GalleryError, match="altered"):
        vault.open(b"", "ann")


def test_without_the_package_the_extra_is_named(tmp_path, monkeypatch):
    really = builtins.__import__

    def without(name, *rest, **kw):
        if name.startswith("cryptography"):
            raise ImportError(name)
        return really(name, *rest, **kw)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(GalleryError, match=r"rangeface\[crypto\]"):
        SqliteGallery(tmp_path / "g.db", key=KEY)
    assert not (tmp_path / "g.db").exists()


def test_keys_that_are_none(tmp_path):
    with pytest.raises(GalleryError, match="not both"):
        read_key({"RANGEFACE_GALLERY_KEY": "x", "RANGEFACE_GALLERY_KEY_FILE": "y"})
    with pytest.raises(GalleryError, match="cannot be read"):
        read_key({"RANGEFACE_GALLERY_KEY_FILE": str(tmp_path / "none")})
    for text in ("x" * 64, "AAAA", "%%%"):
        with pytest.raises(GalleryError, match="64 hexadecimal digits"):
            read_key({"RANGEFACE_GALLERY_KEY": text})


# ── copies and the log ───────────────────────────────────────────────────────────────────


def test_a_backup_replaces_nothing_unless_asked(tmp_path):
    with SqliteGallery(tmp_path / "g.db") as gallery:
        gallery.enroll("ann", template(0))
        gallery.backup(tmp_path / "copy.db")
        with pytest.raises(GalleryError, match="exists"):
            gallery.backup(tmp_path / "copy.db")
        with pytest.raises(GalleryError, match="unable to open"):
            gallery.backup(tmp_path / "none" / "copy.db")


def test_a_damaged_gallery_is_not_backed_up(tmp_path):
    with SqliteGallery(tmp_path / "g.db") as gallery:
        gallery.enroll("ann", template(0))
        raw = sqlite3.connect(tmp_path / "g.db")
        with raw:
            raw.execute("DELETE FROM templates")
        raw.close()
        with pytest.raises(GalleryError, match="damaged"):
            gallery.backup(tmp_path / "copy.db")
    assert not (tmp_path / "copy.db").exists()


def test_exports_that_cannot_be(tmp_path):
    gallery = MemoryGallery()
    with pytest.raises(GalleryError, match="nobody is enrolled"):
        export_gallery(gallery, tmp_path / "all.rfa")
    gallery.enroll("ann", template(0))
    with pytest.raises(GalleryError, match="No such file"):
        export_gallery(gallery, tmp_path / "none" / "all.rfa")


def test_imports_that_cannot_be(tmp_path):
    full, empty = MemoryGallery(), MemoryGallery()
    full.enroll("ann", template(0))
    export_gallery(full, tmp_path / "all.rfa")
    with pytest.raises(GalleryError, match="file not found"):
        import_gallery(empty, tmp_path / "none.rfa")
    write_arrays(tmp_path / "model.rfa", {"kind": "model"}, {})
    with pytest.raises(GalleryError, match="no exported gallery"):
        import_gallery(empty, tmp_path / "model.rfa")
    other = MemoryGallery()
    other.enroll("bob", template(1, fingerprint="g" * 64))
    with pytest.raises(GalleryError, match="enrol everybody again"):
        import_gallery(other, tmp_path / "all.rfa")
    altered = bytearray((tmp_path / "all.rfa").read_bytes())
    altered[-5] ^= 1
    (tmp_path / "all.rfa").write_bytes(altered)
    with pytest.raises(GalleryError, match="altered"):
        import_gallery(empty, tmp_path / "all.rfa")
    assert empty.subjects() == ()
    assert other.subjects() == ("bob",)


@pytest.mark.parametrize(
    "statement",
    [
        "DELETE FROM audit WHERE id = 2",
        "DELETE FROM audit WHERE id = 3",
        "UPDATE audit SET person = 7 WHERE id = 1",
        "DELETE FROM meta WHERE key = 'last audit line'",
    ],
)
def test_a_cut_or_altered_log_is_noticed(tmp_path, statement):
    with SqliteGallery(tmp_path / "g.db") as gallery:
        for i in range(3):
            gallery.enroll(f"p{i}", template(i))
        raw = sqlite3.connect(tmp_path / "g.db")
        with raw:
            raw.execute(statement)
        raw.close()
        with pytest.raises(GalleryError, match=r"audit log|row is missing"):
            gallery.audit()


# ── frontal images ───────────────────────────────────────────────────────────────────────


def test_a_frontal_image_is_never_kept_in_the_clear(tmp_path):
    image = RangeImage(np.zeros((4, 3)), Orthographic(2.0, 1.0, 1.0, 3, 4))
    with SqliteGallery(tmp_path / "g.db") as gallery, MemoryGallery() as memory:
        for place in (gallery, memory):
            with pytest.raises(GalleryError, match="only in an encrypted gallery"):
                place.enroll("ann", template(0), frontal=image)
            assert place.subjects() == ()
            assert place.rebuild(lambda *_: template(1)) == 0


def test_a_rebuild_needs_everybody_s_frontal_image(tmp_path):
    pytest.importorskip("cryptography")
    image = RangeImage(np.zeros((4, 3)), Orthographic(2.0, 1.0, 1.0, 3, 4))
    with SqliteGallery(tmp_path / "g.db", key=KEY) as gallery, MemoryGallery() as memory:
        gallery.enroll("ann", template(0), frontal=image)
        gallery.enroll("bob", template(1))
        memory.enroll("ann", template(0))
        with pytest.raises(GalleryError, match="no frontal image of 1 people, such as 'bob'"):
            gallery.rebuild(lambda *_: template(1, fingerprint="g" * 64))
        with pytest.raises(GalleryError, match="enrol again"):
            memory.rebuild(lambda *_: template(1))
        assert gallery.fingerprint == "f" * 64


def test_a_rebuild_that_fails_changes_nothing(tmp_path):
    pytest.importorskip("cryptography")
    image = RangeImage(np.zeros((4, 3)), Orthographic(2.0, 1.0, 1.0, 3, 4))
    new = iter([template(5, 7, "g" * 64), template(5, 8, "g" * 64)])
    with SqliteGallery(tmp_path / "g.db", key=KEY) as gallery:
        for i in range(2):
            gallery.enroll(f"p{i}", template(i), frontal=image)
        with pytest.raises(GalleryError, match="does not fit"):
            gallery.rebuild(lambda *_: next(new))
        assert gallery.fingerprint == "f" * 64
        np.testing.assert_array_equal(gallery.templates("p0")[0].vectors[0], template(0).vectors[0])


@pytest.mark.parametrize("column", ["payload", "digest"])
def test_an_altered_or_lost_frontal_image_is_noticed(tmp_path, column):
    pytest.importorskip("cryptography")
    image = RangeImage(np.zeros((4, 3)), Orthographic(2.0, 1.0, 1.0, 3, 4))
    with SqliteGallery(tmp_path / "g.db", key=KEY) as gallery:
        gallery.enroll("ann", template(0), frontal=image)
    raw = sqlite3.connect(tmp_path / "g.db")
    with raw:
        raw.execute(f"UPDATE images SET {column} = zeroblob(16)")
    raw.close()
    with (
        SqliteGallery(tmp_path / "g.db", key=KEY) as gallery,
        pytest.raises(GalleryError, match="damaged"),
    ):
        gallery.rebuild(lambda *_: template(1))
