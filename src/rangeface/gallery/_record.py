"""A template as bytes: a JSON header, then raw little-endian float32. Nothing is pickled."""

from __future__ import annotations

import json
import zlib
from dataclasses import asdict
from datetime import date
from hashlib import blake2b
from math import prod

import numpy as np

from rangeface.errors import GalleryError
from rangeface.gallery._protocol import Consent
from rangeface.types import Assessment, Orthographic, RangeImage, Reason, Template

_MAGIC = b"RFT1"
_PLANES = ("depth", "sigma", "amplitude", "filled")


def encode(template: Template) -> bytes:
    """Bytes of a template."""
    header = {
        "fingerprint": template.fingerprint,
        "shapes": [v.shape for v in template.vectors],
        "assessment": None if template.assessment is None else asdict(template.assessment),
    }
    text = json.dumps(header, separators=(",", ":")).encode()
    arrays = [v.astype("<f4").tobytes() for v in template.vectors]
    return b"".join([_MAGIC, len(text).to_bytes(4, "little"), text, *arrays])


def decode(record: bytes) -> Template:
    """The template that `encode` wrote.

    Raises
    ------
    GalleryError
        The bytes are no template.
    """
    try:
        if record[:4] != _MAGIC:
            raise ValueError("wrong first bytes")
        end = 8 + int.from_bytes(record[4:8], "little")
        header = json.loads(record[8:end])
        shapes = [tuple(map(int, shape)) for shape in header["shapes"]]
        if len(record) - end != 4 * sum(map(prod, shapes)):
            raise ValueError("wrong length")
        vectors = []
        for shape in shapes:
            flat = np.frombuffer(record, "<f4", count=prod(shape), offset=end)
            vectors.append(flat.reshape(shape))
            end += flat.nbytes
        return Template(tuple(vectors), header["fingerprint"], _assessment(header["assessment"]))
    except (ValueError, KeyError, TypeError) as error:
        raise GalleryError(f"a record is no template: {error}") from error


def encode_frontal(image: RangeImage) -> bytes:
    """Bytes of a frontal image: a line of JSON, then its planes as packed float32."""
    planes = {name: getattr(image, name) for name in _PLANES if getattr(image, name) is not None}
    header = {"camera": asdict(image.camera), "planes": list(planes)}
    flat = np.stack(list(planes.values()), dtype="<f4", casting="unsafe")
    return json.dumps(header).encode() + b"\n" + zlib.compress(flat.tobytes())


def decode_frontal(record: bytes) -> RangeImage:
    """The image that `encode_frontal` wrote.

    Raises
    ------
    GalleryError
        The bytes are no frontal image.
    """
    try:
        line, _, packed = record.partition(b"\n")
        header = json.loads(line)
        camera = Orthographic(**header["camera"])
        shape = (len(header["planes"]), camera.height, camera.width)
        flat = np.frombuffer(zlib.decompress(packed), "<f4").reshape(shape)
        planes = dict(zip(header["planes"], flat, strict=True))
        if "filled" in planes:
            planes["filled"] = planes["filled"] > 0
        return RangeImage(planes.pop("depth"), camera, **planes)
    except (ValueError, KeyError, TypeError, zlib.error) as error:
        raise GalleryError(f"a record is no frontal image: {error}") from error


def consent_to_text(consent: Consent | None) -> tuple[str | None, str | None]:
    """Reference and last day of a consent."""
    if consent is None:
        return None, None
    return consent.reference, consent.expires.isoformat() if consent.expires else None


def consent_from_text(reference: str | None, expires: str | None) -> Consent | None:
    """The consent that `consent_to_text` took apart."""
    if reference is None:
        return None
    return Consent(reference, date.fromisoformat(expires) if expires else None)


def digest(*parts: object) -> bytes:
    """16 bytes that change when any part, its kind, or the border between two parts changes."""
    state = blake2b(digest_size=16)
    for part in parts:
        data = part if isinstance(part, bytes) else repr(part).encode()
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.digest()


def _assessment(fields: dict[str, object] | None) -> Assessment | None:
    if fields is None:
        return None
    refusals = fields.pop("refusals")
    assert isinstance(refusals, list)
    return Assessment(**fields, refusals=tuple(map(Reason, refusals)))  # type: ignore[arg-type]
