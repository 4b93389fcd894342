"""A file held in memory under limits, and the one way to refuse it."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError, ScanError, ScanFault
from rangeface.types import Camera

_CHUNK = 1 << 16


@dataclass(frozen=True)
class Limits:
    """What a reader accepts before it allocates anything.

    Parameters
    ----------
    max_bytes : int
        Size of a file, and of what it expands to, bytes.
    max_points : int
        Points, and triangles, of a cloud or mesh.
    max_pixels : int
        Pixels of an image.
    max_nesting : int
        Depth of nested nodes (VRML).
    max_ratio : float
        Expanded size over compressed size; what expands to less than 16 MiB is exempt, since
        an empty depth image compresses without limit.

    Raises
    ------
    ParameterError
        A limit is < 1.
    """

    max_bytes: int = 128 << 20
    max_points: int = 4_000_000
    max_pixels: int = 8_388_608
    max_nesting: int = 48
    max_ratio: float = 100.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value >= 1:
                raise ParameterError(f"{name}: a limit must be ≥ 1, got {value}")

    def expanded(self, compressed: int) -> int:
        """Most bytes that `compressed` bytes may expand to."""
        return min(self.max_bytes, max(16 << 20, int(self.max_ratio * compressed)))


@dataclass(frozen=True, eq=False)
class Source:
    """The bytes of a scan file, with what the caller said about it."""

    path: Path
    data: bytes
    limits: Limits = field(default_factory=Limits)
    camera: Camera | None = None
    unit: str | None = None
    alone: bool = False  # bytes that came without a folder have no files beside them

    @classmethod
    def open(
        cls,
        path: str | Path | bytes,
        limits: Limits | None = None,
        camera: Camera | None = None,
        unit: str | None = None,
    ) -> Source:
        """Read a file, its size checked first; or take bytes for the contents of one."""
        limits = limits or Limits()
        if isinstance(path, bytes):
            source = cls(Path("scan"), path, limits, camera, unit, alone=True)
            if len(path) > limits.max_bytes:
                detail = f"{len(path)} bytes, the limit is {limits.max_bytes}"
                raise source.error(ScanFault.TOO_LARGE, detail)
            source.need(0, 1, "a scan")
            return source
        path = Path(path)
        data = _read(path, limits.max_bytes)
        return cls(path, data, limits, camera, unit)

    @property
    def array(self) -> NDArray[np.uint8]:
        """The bytes as an array, not copied."""
        return np.frombuffer(self.data, dtype=np.uint8)

    def error(self, fault: ScanFault, detail: str) -> ScanError:
        """The error to raise when this file is refused."""
        return ScanError(self.path, fault, detail)

    def need(self, offset: int, count: int, what: str) -> None:
        """Refuse the file unless `count` bytes stand at `offset`."""
        present = max(len(self.data) - offset, 0)
        if count > present:
            raise self.error(
                ScanFault.TRUNCATED, f"{what} needs {count} bytes, {present} are there"
            )

    def cap_points(self, count: int, what: str = "points") -> None:
        """Refuse a declared number of points, indices or triangles that is out of bounds."""
        if count < 0:
            raise self.error(ScanFault.MALFORMED, f"declares {count} {what}")
        if count > self.limits.max_points:
            raise self.error(
                ScanFault.TOO_LARGE, f"{count} {what}, the limit is {self.limits.max_points}"
            )

    def cap_pixels(self, width: int, height: int) -> None:
        """Refuse declared dimensions that are out of bounds."""
        if width < 1 or height < 1:
            raise self.error(ScanFault.MALFORMED, f"declares an image of {width} × {height} px")
        if width * height > self.limits.max_pixels:
            raise self.error(
                ScanFault.TOO_LARGE,
                f"image of {width} × {height} px, the limit is {self.limits.max_pixels} px",
            )

    def sibling(self, names: Sequence[str]) -> Source | None:
        """The first of the named files beside this one that exists."""
        for name in () if self.alone else names:
            path = self.path.parent / name
            if path != self.path and path.is_file():
                return replace(self, path=path, data=_read(path, self.limits.max_bytes))
        return None

    def inflate(self, chunks: Sequence[bytes], wbits: int, expected: int | None = None) -> bytes:
        """Expand a deflate stream, and stop at the limits or at `expected` bytes."""
        cap = self.limits.expanded(sum(map(len, chunks)))
        if expected is not None and expected > cap:
            raise self.error(ScanFault.TOO_LARGE, f"expands to {expected} bytes, limit {cap}")
        most = cap if expected is None else expected
        stream = zlib.decompressobj(wbits)
        out = bytearray()
        try:
            for chunk in chunks:
                pending = chunk
                while pending and not stream.eof and len(out) <= most:
                    out += stream.decompress(pending, _CHUNK)
                    pending = stream.unconsumed_tail
        except zlib.error as fault:
            raise self.error(ScanFault.MALFORMED, f"compressed data: {fault}") from None
        if len(out) > most and expected is None:
            raise self.error(ScanFault.TOO_LARGE, f"expands beyond {cap} bytes")
        if expected is None and not stream.eof:
            raise self.error(ScanFault.TRUNCATED, "compressed data end early")
        if expected is not None and len(out) < expected:
            raise self.error(
                ScanFault.TRUNCATED, f"compressed data give {len(out)} of {expected} bytes"
            )
        return bytes(out[:most])


def _read(path: Path, max_bytes: int) -> bytes:
    try:
        path.stat()
        if path.is_dir():
            raise ScanError(path, ScanFault.UNREADABLE, "is a folder")
        if not path.is_file():
            raise ScanError(path, ScanFault.UNREADABLE, "is not a regular file")
        size = path.stat().st_size
        if size > max_bytes:
            raise ScanError(path, ScanFault.TOO_LARGE, f"{size} bytes, the limit is {max_bytes}")
        with path.open("rb") as stream:
            data = stream.read(max_bytes)
    except FileNotFoundError:
        raise ScanError(path, ScanFault.MISSING) from None
    except (OSError, ValueError) as fault:  # ValueError: a NUL in the name
        raise ScanError(path, ScanFault.UNREADABLE, str(fault)) from None
    if not data:
        raise ScanError(path, ScanFault.TRUNCATED, "the file is empty")
    return data
