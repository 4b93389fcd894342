"""The rows of the SQLite gallery under their seal: the exclusive or of all digests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from rangeface.errors import GalleryError
from rangeface.gallery._database import Database
from rangeface.gallery._hand import Hand
from rangeface.gallery._protocol import Consent, NotEnrolledError
from rangeface.gallery._record import digest
from rangeface.gallery._vault import KEY_VARIABLE, Vault
from rangeface.types import RangeImage, Template

_PROOF = b"rangeface gallery"
_PERSON = "id, name, consent, expires, sealed, digest"

#: Name, digest and template.
Known = tuple[str, bytes, Template]


class Rows:
    """People, templates and frontal images as rows; every change keeps the seal.

    Parameters
    ----------
    db : Database
        In whose transactions all of this happens.
    vault : Vault, optional
        Of an encrypted gallery.

    Raises
    ------
    GalleryError
        A row was altered or is missing, the key is wrong, or a person is unknown.
    """

    def __init__(self, db: Database, vault: Vault | None) -> None:
        self._db, self._vault, self._hand = db, vault, Hand(vault)

    # ── reading ──────────────────────────────────────────────────────────────────────────

    def read(
        self, known: Mapping[int, Known]
    ) -> tuple[dict[int, tuple[str, Consent | None]], dict[int, Known]]:
        """People and templates by number; those that are known already are not read again."""
        people, records, marks = {}, {}, []
        for person, *row in self._db.all(f"SELECT {_PERSON} FROM people ORDER BY id"):
            with self._reading():
                people[person] = self._hand.read_person(tuple(row))
            marks.append(row[-1])
        for record, person, mark in self._db.all("SELECT id, person, digest FROM templates"):
            found = known.get(record)
            if found is None or found[1] != mark:
                name, _ = people.get(person, ("", None))
                found = name, mark, self._template(record, name, mark)
            records[record] = found
            marks.append(mark)
        marks += [mark for (mark,) in self._db.all("SELECT digest FROM images")]
        if _xor(bytes(16), *marks) != self._seal():
            raise self._db.damaged("records are missing")
        return people, records

    def frontals(self, known: Mapping[int, Known]) -> dict[int, RangeImage]:
        """The frontal image of every template that has one."""
        found = {}
        for record, payload, mark in self._db.all("SELECT template, payload, digest FROM images"):
            if record not in known:
                raise self._db.damaged("a record is missing")
            with self._reading():
                found[record] = self._hand.read_frontal(known[record][0], payload, mark)
        return found

    def person(self, subject: str) -> int:
        """Number of a person."""
        found = self._find(subject)
        if found is None:
            raise NotEnrolledError(f"{self._db.path}: {subject!r} is not enrolled")
        return found[0]

    # ── writing ──────────────────────────────────────────────────────────────────────────

    def put_person(self, subject: str, consent: Consent | None) -> tuple[int, bool]:
        """Number of a person, who is entered where unknown; whether a consent was replaced."""
        found = self._find(subject)
        if found is not None and consent is None:
            return found[0], False
        row = self._hand.person(subject, consent)
        if found is not None:
            self._db.run(
                "UPDATE people SET name = ?, consent = ?, expires = ?, sealed = ?, digest = ?"
                " WHERE id = ?", *row, found[0],
            )  # fmt: skip
            self._reseal(found[1], row[-1])
            return found[0], True
        person = self._db.run(
            "INSERT INTO people (name, consent, expires, sealed, digest) VALUES (?, ?, ?, ?, ?)",
            *row,
        )
        self._reseal(row[-1])
        return person, False

    def put_template(self, person: int, subject: str, template: Template) -> tuple[int, Known]:
        """Enter a template; gives its number."""
        payload, mark = self._hand.template(subject, template)
        record = self._db.run(
            "INSERT INTO templates (person, payload, digest) VALUES (?, ?, ?)",
            person, payload, mark,
        )  # fmt: skip
        self._reseal(mark)
        return record, (subject, mark, template)

    def replace_template(self, record: int, old: Known, template: Template) -> Known:
        """Write another template in the place of one."""
        payload, mark = self._hand.template(old[0], template)
        self._db.run(
            "UPDATE templates SET payload = ?, digest = ? WHERE id = ?", payload, mark, record
        )
        self._reseal(old[1], mark)
        return old[0], mark, template

    def put_frontal(self, record: int, subject: str, image: RangeImage) -> None:
        """Enter the frontal image of a template."""
        payload, mark = self._hand.frontal(subject, image)
        self._db.run("INSERT INTO images VALUES (?, ?, ?)", record, payload, mark)
        self._reseal(mark)

    def delete(self, person: int) -> int:
        """Delete a person with all templates and images; gives the number of templates."""
        of_person = "template IN (SELECT id FROM templates WHERE person = ?)"
        images = self._db.all(f"SELECT digest FROM images WHERE {of_person}", person)
        templates = self._db.all("SELECT digest FROM templates WHERE person = ?", person)
        people = self._db.all("SELECT digest FROM people WHERE id = ?", person)
        self._db.run(f"DELETE FROM images WHERE {of_person}", person)
        self._db.run("DELETE FROM templates WHERE person = ?", person)
        self._db.run("DELETE FROM people WHERE id = ?", person)
        self._reseal(*(mark for (mark,) in (*images, *templates, *people)))
        return len(templates)

    # ── keys ─────────────────────────────────────────────────────────────────────────────

    def proof(self) -> dict[str, bytes]:
        """What a new gallery is born with, to know its key by."""
        return {} if self._vault is None else {"key proof": self._vault.seal(_PROOF, "")}

    def check_key(self) -> None:
        """Refuse a key that is wrong, missing, or not asked for."""
        row = self._db.find("SELECT value FROM meta WHERE key = 'key proof'")
        if row is None and self._vault is not None:
            raise GalleryError(
                f"{self._db.path}: is not encrypted; export it and import it into a new gallery"
            )
        if row is not None and self._vault is None:
            raise GalleryError(f"{self._db.path}: is encrypted; give its key in {KEY_VARIABLE}")
        if row is not None and self._vault is not None:
            try:
                self._vault.open(row[0], "")
            except GalleryError as error:
                raise GalleryError(f"{self._db.path}: {error}") from error

    def has_plain_names(self) -> bool:
        """Whether an older version left names in the clear that should be sealed."""
        plain = "SELECT id FROM people WHERE sealed IS NULL"
        return self._vault is not None and self._db.find(plain) is not None

    def seal_names(self) -> None:
        """Seal the names and consents that an older version left in the clear."""
        for person, *row in self._db.all(f"SELECT {_PERSON} FROM people WHERE sealed IS NULL"):
            with self._reading():
                name, consent = Hand(None).read_person(tuple(row))
            sealed = self._hand.person(name, consent)
            self._db.run(
                "UPDATE people SET name = ?, consent = ?, expires = ?, sealed = ?, digest = ?"
                " WHERE id = ?", *sealed, person,
            )  # fmt: skip
            self._reseal(row[-1], sealed[-1])
            self._untie(person, name)

    def _untie(self, person: int, name: str) -> None:
        """Take the name out of the digests of a person's templates."""
        for record, payload, mark in self._db.all(
            "SELECT id, payload, digest FROM templates WHERE person = ?", person
        ):
            if mark != digest(name, payload):
                raise self._db.damaged("a record was altered")
            new = digest(self._hand.tag(name), payload)
            self._db.run("UPDATE templates SET digest = ? WHERE id = ?", new, record)
            self._reseal(mark, new)

    # ── details ──────────────────────────────────────────────────────────────────────────

    def _find(self, subject: str) -> tuple[int, bytes] | None:
        tag = self._hand.tag(subject)
        row = self._db.find("SELECT id, digest FROM people WHERE name = ?", tag)
        return None if row is None else (row[0], row[1])

    def _template(self, record: int, name: str, mark: bytes) -> Template:
        (payload,) = self._db.one("SELECT payload FROM templates WHERE id = ?", record)
        with self._reading():
            return self._hand.read_template(name, payload, mark)

    @contextmanager
    def _reading(self) -> Iterator[None]:
        try:
            yield
        except GalleryError as error:
            raise self._db.damaged(str(error)) from error

    def _reseal(self, *marks: bytes) -> None:
        seal = _xor(self._seal(), *marks)
        self._db.run("UPDATE meta SET value = ? WHERE key = 'seal'", seal)

    def _seal(self) -> bytes:
        (seal,) = self._db.one("SELECT value FROM meta WHERE key = 'seal'")
        if not isinstance(seal, bytes) or len(seal) != 16:
            raise self._db.damaged("the seal is broken")
        return seal


def _xor(first: bytes, *others: bytes) -> bytes:
    result = int.from_bytes(first)
    for other in others:
        result ^= int.from_bytes(other)
    return result.to_bytes(len(first))
