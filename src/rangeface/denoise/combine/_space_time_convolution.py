from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._confidence import Confidence, confidence_of
from rangeface.denoise._noise import sigma_map
from rangeface.denoise.combine._frames import alike, divide
from rangeface.numerics import smoothing
from rangeface.types import RangeImage, RigidTransform


def space_time_convolution(
    frames: Iterable[RangeImage],
    *,
    sigma_px: float = 1.0,
    sigma_frames: float = 2.0,
    confidence: Confidence = "amplitude_squared",
    max_step_mm: float = 20.0,
    poses: Sequence[RigidTransform] | None = None,
) -> RangeImage:
    r"""Normalized convolution in space and time (eq. 3.6 in three dimensions).

    .. math:: I'(p) = \frac{\sum_k e^{-k^2 / 2τ^2}\, [g * (C_k I_k)](p)}
                           {\sum_k e^{-k^2 / 2τ^2}\, [g * C_k](p)}

    with k the distance in time, in frames.

    Parameters
    ----------
    frames : iterable of RangeImage
        At least one, all of one camera; the result stands at the *first*, so give them nearest
        first (of a live stream: newest first). One is held beside the first.
    sigma_px : float
        Standard deviation of g, px, > 0.
    sigma_frames : float
        τ, frames, > 0.
    confidence : str
        C, as in `denoise.normalized_convolution`.
    max_step_mm : float
        What lies farther from the first frame's depth (beyond 3√2 σ) is another surface, or the
        same one moved.
    poses : sequence of RigidTransform, optional
        Not used: the head is taken to be still.

    Returns
    -------
    RangeImage
        The holes of the first frame stay holes. σ as if all pixels were independent.

    Raises
    ------
    ParameterError
        There is no frame, the cameras differ, or a parameter is outside its range.

    References
    ----------
    H. Knutsson, C.-F. Westin, CVPR 1993, doi:10.1109/CVPR.1993.341081.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> rng, camera = np.random.default_rng(0), Orthographic(2.8, 24.5, 39.5, 50, 80)
    >>> frames = [RangeImage(500 + rng.normal(0, 4.0, (80, 50)), camera) for _ in range(5)]
    >>> bool(np.std(space_time_convolution(frames).depth) < 1.0)
    True
    """
    del poses
    for name, value in (
        ("sigma_px", sigma_px),
        ("sigma_frames", sigma_frames),
        ("max_step_mm", max_step_mm),
    ):
        _check.positive(name, value)
    kernel = smoothing.gaussian_kernel(sigma_px)
    stream = alike(frames)
    first = next(stream)
    level = np.nan_to_num(first.depth)
    step = np.float32(max_step_mm) + np.float32(3.0 * np.sqrt(2.0)) * sigma_map(first)
    weight = offset = variance = np.zeros(())
    has_sigma = True
    for number, frame in enumerate(chain([first], stream)):
        has_sigma &= frame.sigma is not None
        C = np.exp(-0.5 * (number / sigma_frames) ** 2) * confidence_of(frame, confidence)
        noise = None if frame.sigma is None else frame.sigma * frame.sigma
        mean, spread, mass = smoothing.gated_convolution(
            frame.depth, C.astype(np.float32), noise, first.depth, step, kernel
        )
        weight = weight + mass
        offset = offset + np.where(mass > 0, mass * (mean - level), 0.0)
        if spread is not None:
            variance = variance + np.where(mass > 0, mass**2 * spread, 0.0)
    depth = level + divide(offset, weight)
    return first.with_depth(
        np.where(np.isfinite(depth), depth, first.depth),
        sigma=divide(np.sqrt(variance), weight) if has_sigma else None,
    )
