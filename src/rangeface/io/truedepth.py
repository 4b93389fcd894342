"""Apple TrueDepth exports: a 16-bit PNG in tenths of a millimetre, intrinsics in a JSON.

The JSON stands beside the image (same name, or ``camera.json``, ``calibration.json``,
``intrinsics.json``). The matrix is taken as it is: exports state it for the image at hand
although their reference dimensions say otherwise. Rows or columns first, both are understood.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError, ScanFault
from rangeface.io._source import Source
from rangeface.types import Pinhole

UNIT = "0.1mm"

_NAMES = ("camera.json", "calibration.json", "intrinsics.json")
_KEYS = ("intrinsicmatrix", "intrinsics", "cameramatrix", "k")
_MAX_BYTES = 1 << 20


def intrinsics(source: Source, width: int, height: int) -> Pinhole | None:
    """Camera from the JSON beside an image; None where there is none."""
    beside = source.sibling([source.path.stem + ".json", *_NAMES])
    if beside is None:
        return None
    if len(beside.data) > _MAX_BYTES:
        raise beside.error(ScanFault.TOO_LARGE, f"{len(beside.data)} bytes of JSON")
    try:
        tree = json.loads(beside.data)
    except (ValueError, RecursionError) as fault:
        raise beside.error(ScanFault.MALFORMED, f"no JSON: {fault}") from None
    K = _find(tree)
    if K is None:
        raise beside.error(ScanFault.BAD_CAMERA, "no 3 × 3 intrinsic matrix")
    cx, cy = (K[0, 2], K[1, 2]) if K[0, 2] or K[1, 2] else (K[2, 0], K[2, 1])
    try:
        return Pinhole(float(K[0, 0]), float(K[1, 1]), float(cx), float(cy), width, height)
    except ParameterError as fault:
        raise beside.error(ScanFault.BAD_CAMERA, str(fault)) from None


def _find(tree: Any) -> NDArray[np.float64] | None:
    """The first matrix under a known key, or made of fx, fy, cx, cy; breadth first."""
    queue = [tree]
    for node in queue:
        if isinstance(node, dict):
            if all(_is_number(node.get(name)) for name in ("fx", "fy", "cx", "cy")):
                return np.array(
                    [[node["fx"], 0.0, node["cx"]], [0.0, node["fy"], node["cy"]], [0.0, 0.0, 1.0]]
                )
            for key, value in node.items():
                matrix = _matrix(value) if key.lower().replace("_", "") in _KEYS else None
                if matrix is not None:
                    return matrix
            queue.extend(node.values())
        elif isinstance(node, list):
            queue.extend(node)
    return None


def _matrix(value: Any) -> NDArray[np.float64] | None:
    flat = [x for row in value for x in (row if isinstance(row, list) else [row])] if (
        isinstance(value, list) and len(value) in (3, 9)
    ) else []  # fmt: skip
    if len(flat) != 9 or not all(_is_number(x) for x in flat):
        return None
    return np.array(flat, dtype=np.float64).reshape(3, 3)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
