"""Templates, names and consents at rest: AES-256-GCM."""

from __future__ import annotations

import base64
import binascii
import os
from collections.abc import Mapping
from hashlib import blake2b
from pathlib import Path

from rangeface.errors import GalleryError

KEY_VARIABLE = "RANGEFACE_GALLERY_KEY"
KEY_FILE_VARIABLE = "RANGEFACE_GALLERY_KEY_FILE"

_NONCE_BYTES = 12


class Vault:
    """Seals bytes so that they cannot be read, altered or put under another name.

    Parameters
    ----------
    key : bytes
        32 random bytes.

    Raises
    ------
    GalleryError
        The key has another length, the package *cryptography* is missing, or what is opened was
        sealed with another key, under another name, or was altered.

    Notes
    -----
    AES-256-GCM with a fresh random 96-bit nonce for every record, and the name as associated
    data (NIST SP 800-38D).
    """

    def __init__(self, key: bytes) -> None:
        try:
            from cryptography.hazmat.primitives.ciphers.aead import AESGCM
        except ImportError as error:
            raise GalleryError(
                "an encrypted gallery needs the extra: pip install 'rangeface[crypto]'"
            ) from error
        if len(key) != 32:
            raise GalleryError(f"key: need 32 bytes (256 bits), got {len(key)}")
        self._cipher = AESGCM(key)
        self._names = blake2b(key=key, person=b"rangeface names").digest()[:32]

    def tag(self, name: str) -> str:
        """What stands for a name where it must be found again: nobody can guess it back."""
        return blake2b(name.encode(), key=self._names, digest_size=16).hexdigest()

    def seal(self, data: bytes, name: str) -> bytes:
        """Nonce, ciphertext and tag of the data."""
        nonce = os.urandom(_NONCE_BYTES)
        return nonce + self._cipher.encrypt(nonce, data, name.encode())

    def open(self, sealed: bytes, name: str) -> bytes:
        """The data that were sealed under this name."""
        from cryptography.exceptions import InvalidTag

        try:
            return self._cipher.decrypt(sealed[:_NONCE_BYTES], sealed[_NONCE_BYTES:], name.encode())
        except (InvalidTag, ValueError) as error:
            raise GalleryError("wrong key, or the record was altered") from error


def read_key(environment: Mapping[str, str] = os.environ) -> bytes | None:
    """The key that the environment names.

    Parameters
    ----------
    environment : mapping
        ``RANGEFACE_GALLERY_KEY`` holds the key itself, ``RANGEFACE_GALLERY_KEY_FILE`` the path of
        a file with it: 64 hexadecimal digits, or base64 of 32 bytes.

    Returns
    -------
    bytes or None
        None where neither is set.

    Raises
    ------
    GalleryError
        The file cannot be read, both are set, or the text is no key.

    Examples
    --------
    >>> read_key({"RANGEFACE_GALLERY_KEY": "00" * 32}) == bytes(32)
    True
    """
    text, file = environment.get(KEY_VARIABLE), environment.get(KEY_FILE_VARIABLE)
    if text and file:
        raise GalleryError(f"set {KEY_VARIABLE} or {KEY_FILE_VARIABLE}, not both")
    if file:
        try:
            text = Path(file).read_text(encoding="ascii")
        except (OSError, UnicodeDecodeError) as error:
            raise GalleryError(f"{file}: the key cannot be read ({error})") from error
    return _parse(text.strip()) if text else None


def _parse(text: str) -> bytes:
    try:
        key = bytes.fromhex(text) if len(text) == 64 else base64.b64decode(text, validate=True)
    except (ValueError, binascii.Error):
        key = b""
    if len(key) != 32:
        raise GalleryError("key: need 64 hexadecimal digits, or base64 of 32 bytes")
    return key
