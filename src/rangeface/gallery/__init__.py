"""enrolled templates behind one protocol."""

from __future__ import annotations

from os import PathLike, fspath

from rangeface.errors import GalleryError
from rangeface.gallery._memory import MemoryGallery
from rangeface.gallery._protocol import (
    AuditEntry,
    Consent,
    Gallery,
    NotEnrolledError,
    View,
    check_fingerprint,
    stack,
)
from rangeface.gallery._record import decode as template_from_bytes
from rangeface.gallery._record import decode_frontal as frontal_from_bytes
from rangeface.gallery._record import encode as template_to_bytes
from rangeface.gallery._record import encode_frontal as frontal_to_bytes
from rangeface.gallery._sqlite import SqliteGallery
from rangeface.gallery._transfer import export_gallery, import_gallery
from rangeface.gallery._vault import KEY_VARIABLE, read_key


def open_gallery(
    url: str | PathLike[str], *, create: bool = True, key: bytes | None = None
) -> Gallery:
    """Open a gallery by its address.

    Parameters
    ----------
    url : str or PathLike
        ``sqlite:///gallery.db`` (a relative path), ``sqlite:////var/gallery.db`` (an absolute
        one), ``memory://``, or just the path of an SQLite file.
    create : bool
        Make the file where it is missing.
    key : bytes, optional
        32 bytes, for a gallery that is encrypted. None: what `read_key` finds in the environment.

    Returns
    -------
    Gallery

    Raises
    ------
    GalleryError
        The kind of address is unknown, or the file is missing, damaged or no gallery.

    Examples
    --------
    >>> open_gallery("memory://").subjects()
    ()
    """
    address = fspath(url)
    scheme, separator, rest = address.partition("://")
    if not separator:
        return SqliteGallery(address, create=create, key=key or read_key())
    if scheme == "memory":
        return MemoryGallery()
    if scheme == "sqlite" and rest.startswith("/") and len(rest) > 1:
        return SqliteGallery(rest[1:], create=create, key=key or read_key())
    raise GalleryError(f"{address}: unknown gallery; use sqlite:///FILE, memory:// or a path")


__all__ = [
    "KEY_VARIABLE",
    "AuditEntry",
    "Consent",
    "Gallery",
    "MemoryGallery",
    "NotEnrolledError",
    "SqliteGallery",
    "View",
    "check_fingerprint",
    "export_gallery",
    "frontal_from_bytes",
    "frontal_to_bytes",
    "import_gallery",
    "open_gallery",
    "read_key",
    "stack",
    "template_from_bytes",
    "template_to_bytes",
]
