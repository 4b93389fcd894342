"""What wavelet denoisers share: holes, the level of the noise, and the rules of shrinkage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

import cv2
import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._noise import sigma_map
from rangeface.errors import ParameterError
from rangeface.numerics import holes, shrinkage
from rangeface.types import Float32, Mask, RangeImage

Rule: TypeAlias = Literal["soft", "bayes", "bivariate", "wiener"]
Bands: TypeAlias = tuple[Float32, Float32, Float32]

_RULES = ("soft", "bayes", "bivariate", "wiener")
_WINDOW_PX = 7
# after the bivariate pilot; a third pass changes little
_WIENER_PASSES = 2


class Coefficients(Protocol):
    """What a transform gives: per level, finest first, three sub-bands."""

    details: list[Bands]


class Transform(NamedTuple):
    r"""A transform, and how the coefficients lie in its sub-bands.

    Parameters
    ----------
    analyse, synthesise : callable
        Plane → coefficients, and back.
    gains : list of (side, diagonal)
        Per level, the standard deviation of white unit noise in a real part.
    stride : int
        A coefficient has stride × stride samples of the sub-band to itself.
    parts : int
        1 real, 2 complex.
    magnitudes : callable
        Sub-band → the magnitudes of the coefficients, one image an orientation.
    soft : callable
        (sub-band, threshold image) → mean squared gain; shrinks in place.
    wiener : callable
        (sub-band, the pilot's, σ image) → mean squared gain; shrinks in place by

        .. math:: g = \frac{|x|^2}{|x|^2 + p\, σ^2}
    scale : callable
        (sub-band, one gain image an orientation); scales in place.
    """

    analyse: Callable[[Float32], Any]
    synthesise: Callable[[Any], Float32]
    gains: list[tuple[float, float]]
    stride: int
    parts: int
    magnitudes: Callable[[Float32], tuple[Float32, ...]]
    soft: Callable[[Float32, Float32], float]
    wiener: Callable[[Float32, Float32, Float32], float]
    scale: Callable[..., None]


class Rules(NamedTuple):
    """The user's choice of a threshold."""

    shrinkage: Rule
    threshold_sigma: float
    threshold_mm: float | None
    per_pixel_sigma: bool


def check(rules: Rules) -> None:
    """Refuse an unknown rule and a negative threshold."""
    if rules.shrinkage not in _RULES:
        raise ParameterError(f"shrinkage: {rules.shrinkage!r} is none of {', '.join(_RULES)}")
    _check.not_negative("threshold_sigma", rules.threshold_sigma)
    if rules.threshold_mm is not None:
        _check.not_negative("threshold_mm", rules.threshold_mm)


def denoise(image: RangeImage, transform: Transform, rules: Rules) -> RangeImage:
    """Shrink an image's coefficients; its holes are closed smoothly and opened again after."""
    if not image.mask.any():
        return image
    level = np.float32(np.nanmean(image.depth))
    sigma = sigma_map(image)
    if not rules.per_pixel_sigma:
        sigma = np.full(image.shape, np.median(sigma[image.mask]), dtype=np.float32)
    box = _box(image.mask)
    valid = image.mask[box]
    plane = holes.extended(image.depth[box] - level, valid)
    out, left = _shrunk(plane, np.ascontiguousarray(sigma[box]), transform, rules)
    depth = image.depth.copy()
    depth[box] = np.where(valid, out + level, np.float32(np.nan))
    after = None if image.sigma is None else image.sigma * np.float32(np.sqrt(left))
    return image.with_depth(depth, sigma=after)


def _box(mask: Mask) -> tuple[slice, slice]:
    """Smallest window that holds all valid pixels."""
    rows, cols = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(cols[0]), int(cols[-1]) + 1)


def _shrunk(
    plane: Float32, sigma: Float32, transform: Transform, rules: Rules
) -> tuple[Float32, float]:
    """The plane after shrinkage, and the part of the noise's energy that is left.

    σ of a coefficient is that of the pixels around it: the local mean of σ², taken to the
    coefficient's grid, times the sub-band's gain for white noise.
    """
    bands: Coefficients = transform.analyse(plane)
    noise = [
        [gain * local for gain in (side, side, diagonal)]
        for local, (side, diagonal) in zip(
            _local(sigma, bands.details, transform), transform.gains, strict=True
        )
    ]
    if rules.threshold_mm is not None or rules.shrinkage in ("soft", "bayes"):
        kept = [
            [_soft(b, s, transform, rules) for b, s in zip(detail, at, strict=True)]
            for detail, at in zip(bands.details, noise, strict=True)
        ]
    else:
        kept = _bivariate(bands.details, noise, transform)
    out = transform.synthesise(bands)
    if rules.threshold_mm is None and rules.shrinkage == "wiener":
        for _ in range(_WIENER_PASSES):
            pilot, bands = transform.analyse(out), transform.analyse(plane)
            kept = [
                [transform.wiener(*band) for band in zip(*level, strict=True)]
                for level in zip(bands.details, pilot.details, noise, strict=True)
            ]
            out = transform.synthesise(bands)
    # white noise of a dyadic transform: 3/4 of what came in stays in each level's details
    shares = 0.25 ** np.arange(len(kept))
    return out, float(0.75 * shares @ np.mean(kept, axis=1) + 0.25 * shares[-1])


def _local(sigma: Float32, details: list[Bands], transform: Transform) -> list[Float32]:
    """σ on the grid of each level's coefficients; levels 1, 3, … lie transposed."""
    out, variance = [], sigma * sigma
    for number, detail in enumerate(details, start=1):
        rows, cols = (n // transform.stride for n in detail[0].shape)
        size = (rows, cols) if number % 2 else (cols, rows)
        variance = cv2.resize(variance, size, interpolation=cv2.INTER_AREA).reshape(size[::-1])
        local = np.sqrt(variance)
        out.append(np.ascontiguousarray(local.T) if number % 2 else local)
    return out


def _soft(band: Float32, noise: Float32, transform: Transform, rules: Rules) -> float:
    if rules.threshold_mm is not None:
        return transform.soft(band, np.full_like(noise, rules.threshold_mm))
    if rules.shrinkage == "soft":
        return transform.soft(band, np.float32(rules.threshold_sigma) * noise)
    known = np.where(noise > 0, noise, np.float32(np.inf))
    energy = (
        np.mean([np.mean((m / known) ** 2) for m in transform.magnitudes(band)]) / transform.parts
    )
    return transform.soft(band, np.float32(shrinkage.bayes_threshold(float(energy))) * noise)


def _bivariate(
    details: list[Bands], noise: list[list[Float32]], transform: Transform
) -> list[list[float]]:
    # all magnitudes first: a parent counts as it was measured, not as it was shrunk
    sizes: list[list[list[Float32]]] = [
        [
            [_relative(m, s) for m in transform.magnitudes(band)]
            for band, s in zip(detail, at, strict=True)
        ]
        for detail, at in zip(details, noise, strict=True)
    ]
    kept = []
    for number, detail in enumerate(details):
        parents = sizes[number + 1] if number + 1 < len(details) else None
        for b, band in enumerate(detail):
            gains = []
            for o, m in enumerate(sizes[number][b]):
                # the coarser level lies transposed to this one, with lh and hl exchanged
                parent = None if parents is None else _spread(parents[(1, 0, 2)[b]][o], m)
                gains.append(shrinkage.bivariate_gain(m, parent, transform.parts, _WINDOW_PX))
            kept.append(_scaled(band, gains, transform))
    return np.reshape(kept, (-1, 3)).tolist()


def _scaled(band: Float32, gains: list[Float32], transform: Transform) -> float:
    transform.scale(band, *gains)
    return float(np.mean([np.mean(gain * gain) for gain in gains]))


def _relative(magnitude: Float32, noise: Float32) -> Float32:
    floor: Float32 = np.maximum(noise, np.float32(1e-12))
    return magnitude / floor


def _spread(parent: Float32, child: Float32) -> Float32:
    """A coarser level's magnitudes at the places of a finer level's."""
    upright = np.ascontiguousarray(parent.T)
    size = (child.shape[1], child.shape[0])
    return cv2.resize(upright, size, interpolation=cv2.INTER_NEAREST).reshape(child.shape)
