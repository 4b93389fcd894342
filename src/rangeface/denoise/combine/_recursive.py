from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from rangeface.denoise import _check
from rangeface.denoise.combine._frames import alike, measured
from rangeface.errors import ParameterError
from rangeface.types import RangeImage, RigidTransform


def recursive(
    frames: Iterable[RangeImage],
    *,
    gain: float = 0.3,
    max_step_mm: float = 20.0,
    poses: Sequence[RigidTransform] | None = None,
) -> RangeImage:
    r"""Recursive filter of every pixel, restarted where the scene changes.

    .. math:: \hat z_k = \hat z_{k-1} + g_k (z_k - \hat z_{k-1}), \qquad
              σ_k^2 = (1 - g_k)^2 σ_{k-1}^2 + g_k^2 σ^2

    Parameters
    ----------
    frames : iterable of RangeImage
        At least one, all of one camera; read once, one held at a time. The result stands at the
        last of them.
    gain : float
        g in the long run, 0 < g ≤ 1; the n-th measurement of a pixel counts max(g, 1/n), so
        that the filter starts as a plain mean.
    max_step_mm : float
        A measurement that differs by more (beyond 3√2 σ) restarts its pixel.
    poses : sequence of RigidTransform, optional
        Not used: the head is taken to be still.

    Returns
    -------
    RangeImage
        A pixel that the last frame did not measure keeps its estimate, marked in `filled`. σ
        where every frame has it; the amplitude is the last frame's.

    Raises
    ------
    ParameterError
        There is no frame, the cameras differ, or a parameter is outside its range.

    Examples
    --------
    >>> from rangeface.types import Pinhole
    >>> camera = Pinhole(200, 200, 0, 0, 1, 1)
    >>> frames = [RangeImage([[z]], camera) for z in (400.0, 402.0, 407.0)]
    >>> float(recursive(frames).depth[0, 0])
    403.0
    """
    del poses
    if not 0.0 < gain <= 1.0:
        raise ParameterError(f"gain must lie in 0 … 1, got {gain}")
    _check.positive("max_step_mm", max_step_mm)
    depth = variance = count = np.zeros(())
    has_sigma = True
    for frame in alike(frames):
        seen = measured(frame)
        noise = np.zeros(frame.shape) if frame.sigma is None else np.nan_to_num(frame.sigma) ** 2
        has_sigma &= frame.sigma is not None
        step = max_step_mm + 3.0 * np.sqrt(2.0 * noise)
        moved = seen & (count > 0) & (np.abs(np.nan_to_num(frame.depth) - depth) > step)
        count = np.where(moved, 0, count) + seen
        g = np.where(seen, np.maximum(gain, 1.0 / np.maximum(count, 1)), 0.0)
        g = np.where(count == 1, seen, g)
        depth = (1.0 - g) * depth + g * np.where(seen, frame.depth, 0.0)
        variance = (1.0 - g) ** 2 * variance + g**2 * noise
    known = count > 0
    return frame.with_depth(
        np.where(known, depth, np.nan),
        sigma=np.where(known, np.sqrt(variance), np.nan) if has_sigma else None,
        filled=known & ~seen,
    )
