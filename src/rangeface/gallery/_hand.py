"""How people, templates and frontal images are written into rows, in the clear or sealed."""

from __future__ import annotations

import json
from typing import Any

from rangeface.errors import GalleryError
from rangeface.gallery._protocol import Consent
from rangeface.gallery._record import (
    consent_from_text,
    consent_to_text,
    decode,
    decode_frontal,
    digest,
    encode,
    encode_frontal,
)
from rangeface.gallery._vault import Vault
from rangeface.types import RangeImage, Template

#: name or tag, reference and last day of the consent, all three sealed, digest
PersonRow = tuple[str, str | None, str | None, bytes | None, bytes]


class Hand:
    """Writes and reads the rows of a gallery.

    Parameters
    ----------
    vault : Vault, optional
        Then a name is a keyed tag, and name, consent and template are sealed.

    Raises
    ------
    GalleryError
        What is read was altered, or sealed with another key.
    """

    def __init__(self, vault: Vault | None) -> None:
        self._vault = vault

    def tag(self, name: str) -> str:
        """What a person is found by."""
        return name if self._vault is None else self._vault.tag(name)

    def person(self, name: str, consent: Consent | None) -> PersonRow:
        """Columns of a person."""
        reference, expires = consent_to_text(consent)
        if self._vault is None:
            return name, reference, expires, None, digest(name, reference, expires)
        tag = self.tag(name)
        sealed = self._vault.seal(json.dumps([name, reference, expires]).encode(), tag)
        return tag, None, None, sealed, digest(tag, sealed)

    def read_person(self, row: PersonRow) -> tuple[str, Consent | None]:
        """Name and consent of a person."""
        tag, reference, expires, sealed, mark = row
        if self._vault is None:
            _check(mark, tag, reference, expires)
            return tag, consent_from_text(reference, expires)
        if sealed is None:
            raise GalleryError("a record was altered")
        _check(mark, tag, sealed)
        name, reference, expires = json.loads(self._vault.open(sealed, tag))
        return name, consent_from_text(reference, expires)

    def template(self, name: str, template: Template) -> tuple[bytes, bytes]:
        """Payload and digest of a template."""
        return self._payload(encode(template), name)

    def read_template(self, name: str, payload: bytes, mark: bytes) -> Template:
        """The template of a payload."""
        return decode(self._opened(name, payload, mark))

    def frontal(self, name: str, image: RangeImage) -> tuple[bytes, bytes]:
        """Payload and digest of a frontal image, which is never written in the clear."""
        if self._vault is None:
            raise GalleryError("a frontal image is kept only in an encrypted gallery")
        return self._payload(encode_frontal(image), name)

    def read_frontal(self, name: str, payload: bytes, mark: bytes) -> RangeImage:
        """The frontal image of a payload."""
        return decode_frontal(self._opened(name, payload, mark))

    def _payload(self, plain: bytes, name: str) -> tuple[bytes, bytes]:
        payload = plain if self._vault is None else self._vault.seal(plain, name)
        return payload, digest(self.tag(name), payload)

    def _opened(self, name: str, payload: bytes, mark: bytes) -> bytes:
        _check(mark, self.tag(name), payload)
        return payload if self._vault is None else self._vault.open(payload, name)


def _check(mark: bytes, *parts: Any) -> None:
    if mark != digest(*parts):
        raise GalleryError("a record was altered")
