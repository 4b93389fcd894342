"""A frame as bytes for the page: a head of JSON, and planes of uint16.

The layout: length of the head (uint32, little-endian), the head (UTF-8, padded with blanks to a
multiple of four bytes), and each plane row by row, padded likewise. The page's `protocol.ts` is
the other side.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rangeface.types import Float32

_LEVELS = 65535


@dataclass(frozen=True, eq=False)
class Plane:
    """A depth plane to be sent.

    Parameters
    ----------
    name : str
        "depth" or "surface".
    depth : (H, W) float32
        mm; NaN where invalid.
    step_mm : float
        Quantum, > 0; what lies outside 65,534 of them from the nearest pixel is left out.
    extra : mapping
        Further fields of its head.
    """

    name: str
    depth: Float32
    step_mm: float
    extra: Mapping[str, Any]


def encode(head: Mapping[str, Any], planes: Sequence[Plane]) -> bytes:
    r"""The bytes of one frame.

    Parameters
    ----------
    head : mapping
        JSON; "planes" is added.
    planes : sequence of Plane

    Returns
    -------
    bytes

    Examples
    --------
    >>> flat = Plane("depth", np.full((1, 2), 400.0, np.float32), 0.5, {})
    >>> encode({"frame": 1}, [flat])[-4:]
    b'\x01\x00\x01\x00'
    """
    heads, bodies = [], []
    for plane in planes:
        offset_mm, values = _quantised(plane.depth, plane.step_mm)
        rows, cols = values.shape
        heads.append(
            {"name": plane.name, "rows": rows, "cols": cols, "offset_mm": offset_mm,
             "step_mm": plane.step_mm, **plane.extra}
        )  # fmt: skip
        bodies.append(_padded(values.tobytes(), b"\0"))
    text = _padded(json.dumps({**head, "planes": heads}, allow_nan=False).encode(), b" ")
    return b"".join([len(text).to_bytes(4, "little"), text, *bodies])


def _quantised(
    depth: Float32, step_mm: float
) -> tuple[float, np.ndarray[Any, np.dtype[np.uint16]]]:
    """Offset and levels 1 … 65535 of a plane; 0 is invalid."""
    valid = np.isfinite(depth)
    if not valid.any():
        return 0.0, np.zeros(depth.shape, "<u2")
    offset_mm = float(depth[valid].min()) - step_mm
    levels = np.rint((np.where(valid, depth, offset_mm) - offset_mm) / step_mm)
    return offset_mm, np.where(levels <= _LEVELS, levels, 0).astype("<u2")


def _padded(data: bytes, blank: bytes) -> bytes:
    return data + blank * (-len(data) % 4)
