"""A file of named arrays behind a JSON header: no pickle, nothing executed, every byte checked.

Layout: the magic line, the header's length as a little-endian u64, the header (UTF-8 JSON:
``{"meta": …, "arrays": [{"name", "dtype", "shape", "offset", "sha256"}, …], "sha256": …}``),
then the arrays' bytes, little-endian, C order, one after the other. float32 numbers that are
exactly a power of two times half-precision ones are kept as those, beside the "exponent".
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rangeface.errors import ScanError, ScanFault

_MAGIC = b"rangeface arrays 1\n"
_DTYPES = {"<f2", "<f4", "<f8", "<i4", "<i8", "|u1", "|b1"}
_MAX_HEADER_BYTES = 16 * 2**20
_MAX_BYTES = 2 * 2**30


def write_arrays(path: Path, meta: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Write arrays and their header; the file appears whole or not at all.

    Parameters
    ----------
    path : Path
        File to write; an older one is replaced only when the new one is safe on the disk.
    meta : mapping
        Anything that JSON can say.
    arrays : mapping of str to array
        float32, float64, int32, int64, uint8 or bool.
    """
    table, blocks, offset = [], [], 0
    for name, array in arrays.items():
        block, exponent = _packed(np.asarray(array))
        block = np.ascontiguousarray(block).astype(block.dtype.newbyteorder("<"))
        raw = block.tobytes()
        entry: dict[str, Any] = {"name": name, "dtype": block.dtype.str, "shape": list(block.shape)}
        if exponent:
            entry["exponent"] = exponent
        table.append({**entry, "offset": offset, "sha256": hashlib.sha256(raw).hexdigest()})
        blocks.append(raw)
        offset += len(raw)
    body = {"meta": meta, "arrays": table}
    seal = hashlib.sha256(json.dumps(body, sort_keys=True).encode()).hexdigest()
    header = json.dumps({**body, "sha256": seal}, sort_keys=True).encode()
    partial = path.with_name(path.name + ".partial")
    with open(partial, "wb") as file:
        file.write(_MAGIC + struct.pack("<Q", len(header)) + header)
        file.writelines(blocks)
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)


def _packed(array: np.ndarray) -> tuple[np.ndarray, int]:
    """Half precision and its exponent where that loses nothing, else the array and 0."""
    if array.dtype != np.float32 or not np.isfinite(array).all() or not array.any():
        return array, 0
    exponent = int(np.frexp(np.abs(array).max())[1])
    half = np.ldexp(array, -exponent).astype(np.float16)
    exact = np.array_equal(np.ldexp(half.astype(np.float32), exponent), array)
    return (half, exponent) if exact else (array, 0)


def read_arrays(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Read what `write_arrays` wrote; a flipped byte is noticed.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    meta : dict
    arrays : dict of str to array

    Raises
    ------
    ScanError
        The file is missing, truncated, of another kind, or its bytes do not match its hashes.
    """
    if not path.is_file():
        raise ScanError(path, ScanFault.MISSING)
    if path.stat().st_size > _MAX_BYTES:
        raise ScanError(path, ScanFault.TOO_LARGE, f"more than {_MAX_BYTES} bytes")
    raw = path.read_bytes()
    start = len(_MAGIC) + 8
    if not raw.startswith(_MAGIC):
        raise ScanError(path, ScanFault.UNKNOWN_FORMAT, "not a rangeface file of arrays")
    if len(raw) < start:
        raise ScanError(path, ScanFault.TRUNCATED, "the header is missing")
    (length,) = struct.unpack("<Q", raw[len(_MAGIC) : start])
    if length > min(_MAX_HEADER_BYTES, len(raw) - start):
        raise ScanError(path, ScanFault.TRUNCATED, "the header is cut off")
    try:
        header = json.loads(raw[start : start + length])
        seal = header.pop("sha256")
        if hashlib.sha256(json.dumps(header, sort_keys=True).encode()).hexdigest() != seal:
            raise ScanError(path, ScanFault.MALFORMED, "the header does not match its hash")
        base = start + length
        arrays = {entry["name"]: _block(path, raw, base, entry) for entry in header["arrays"]}
        return dict(header["meta"]), arrays
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ScanError(path, ScanFault.MALFORMED, f"broken header ({error})") from error


def _block(path: Path, raw: bytes, base: int, entry: dict[str, Any]) -> np.ndarray:
    if entry["dtype"] not in _DTYPES:
        raise ScanError(path, ScanFault.MALFORMED, f"array type {entry['dtype']!r}")
    dtype = np.dtype(entry["dtype"])
    size = math.prod(entry["shape"]) * dtype.itemsize
    start = base + int(entry["offset"])
    block = raw[start : start + size]
    if len(block) != size:
        raise ScanError(path, ScanFault.TRUNCATED, f"array {entry['name']!r} is cut off")
    if hashlib.sha256(block).hexdigest() != entry["sha256"]:
        raise ScanError(path, ScanFault.MALFORMED, f"array {entry['name']!r} was altered")
    array = np.frombuffer(block, dtype).reshape(entry["shape"])
    if dtype == np.float16:
        return np.ldexp(array.astype(np.float32), int(entry.get("exponent", 0)))
    return array
