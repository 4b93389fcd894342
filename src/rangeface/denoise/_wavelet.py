"""What wavelet denoisers share: holes, the level of the noise, and the rules of shrinkage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias

import cv2
import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._noise import sigma_map
from rangeface.errors import ParameterError
from rangeface.numerics import holes, shrinkage
from rangeface.types import Float32, RangeImage

Rule: TypeAlias = Literal["soft", "bayes", "bivariate"]
Bands: TypeAlias = tuple[Float32, Float32, Float32]

_RULES = ("soft", "bayes", "bivariate")
_WINDOW_PX = 7


class Kind(NamedTuple):
    """How the coefficients of a transform lie in its sub-bands.

    Parameters
    ----------
    stride : int
        A coefficient has stride × stride samples of the sub-band to itself.
    parts : int
        1 real, 2 complex.
    magnitudes : callable
        Sub-band → the magnitudes of the coefficients, one image an orientation.
    soft : callable
        (sub-band, threshold image) → mean squared gain; shrinks in place.
    scale : callable
        (sub-band, one gain image an orientation); scales in place.
    """

    stride: int
    parts: int
    magnitudes: Callable[[Float32], tuple[Float32, ...]]
    soft: Callable[[Float32, Float32], float]
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


def denoise(
    image: RangeImage, rules: Rules, through: Callable[[Float32, Float32], tuple[Float32, float]]
) -> RangeImage:
    """Send the image through a transform, its holes closed smoothly and opened again after.

    `through` takes the plane and σ (both finite) and returns the plane and the part of the
    noise's energy that is left.
    """
    if not image.mask.any():
        return image
    level = np.float32(np.nanmedian(image.depth))
    plane = holes.extended(image.depth - level, image.mask)
    sigma = sigma_map(image)
    if not rules.per_pixel_sigma:
        sigma = np.full(image.shape, np.median(sigma[image.mask]), dtype=np.float32)
    out, left = through(plane, sigma)
    depth = np.where(image.mask, out + level, np.float32(np.nan))
    after = None if image.sigma is None else image.sigma * np.float32(np.sqrt(left))
    return image.with_depth(depth, sigma=after)


def shrink(
    details: list[Bands],
    sigma: Float32,
    gains: list[tuple[float, float]],
    kind: Kind,
    rules: Rules,
) -> float:
    """Shrink the sub-bands of all levels in place; returns the noise energy that is left.

    σ of a coefficient is that of the pixels around it: the local mean of σ², taken to the
    coefficient's grid, times the sub-band's gain for white noise.
    """
    noise = [
        [gain * local for gain in (side, side, diagonal)]
        for local, (side, diagonal) in zip(_local(sigma, details, kind), gains, strict=True)
    ]
    if rules.shrinkage == "bivariate" and rules.threshold_mm is None:
        kept = _bivariate(details, noise, kind)
    else:
        kept = [
            float(np.mean([_soft(b, s, kind, rules) for b, s in zip(detail, at, strict=True)]))
            for detail, at in zip(details, noise, strict=True)
        ]
    # white noise of a dyadic transform: 3/4 of what came in stays in each level's details
    shares = 0.25 ** np.arange(len(details))
    return float(0.75 * shares @ kept + 0.25 * shares[-1])


def _local(sigma: Float32, details: list[Bands], kind: Kind) -> list[Float32]:
    """σ on the grid of each level's coefficients; levels 1, 3, … lie transposed."""
    out, variance = [], sigma * sigma
    for number, detail in enumerate(details, start=1):
        rows, cols = (n // kind.stride for n in detail[0].shape)
        size = (rows, cols) if number % 2 else (cols, rows)
        variance = cv2.resize(variance, size, interpolation=cv2.INTER_AREA).reshape(size[::-1])
        local = np.sqrt(variance)
        out.append(np.ascontiguousarray(local.T) if number % 2 else local)
    return out


def _soft(band: Float32, noise: Float32, kind: Kind, rules: Rules) -> float:
    if rules.threshold_mm is not None:
        return kind.soft(band, np.full_like(noise, rules.threshold_mm))
    if rules.shrinkage == "soft":
        return kind.soft(band, np.float32(rules.threshold_sigma) * noise)
    known = np.where(noise > 0, noise, np.float32(np.inf))
    energy = np.mean([np.mean((m / known) ** 2) for m in kind.magnitudes(band)]) / kind.parts
    return kind.soft(band, np.float32(shrinkage.bayes_threshold(float(energy))) * noise)


def _bivariate(details: list[Bands], noise: list[list[Float32]], kind: Kind) -> list[float]:
    # all magnitudes first: a parent counts as it was measured, not as it was shrunk
    sizes: list[list[list[Float32]]] = [
        [
            [_relative(m, s) for m in kind.magnitudes(band)]
            for band, s in zip(detail, at, strict=True)
        ]
        for detail, at in zip(details, noise, strict=True)
    ]
    kept = []
    for number, detail in enumerate(details):
        energy = []
        for b, band in enumerate(detail):
            parents = None
            if number + 1 < len(details):
                # the coarser level lies transposed to this one, with lh and hl exchanged
                parents = sizes[number + 1][(1, 0, 2)[b]]
            gains = [
                shrinkage.bivariate_gain(
                    m, None if parents is None else _spread(parents[o], m), kind.parts, _WINDOW_PX
                )
                for o, m in enumerate(sizes[number][b])
            ]
            kind.scale(band, *gains)
            energy += [float(np.mean(g * g)) for g in gains]
        kept.append(float(np.mean(energy)))
    return kept


def _relative(magnitude: Float32, noise: Float32) -> Float32:
    floor: Float32 = np.maximum(noise, np.float32(1e-12))
    return magnitude / floor


def _spread(parent: Float32, child: Float32) -> Float32:
    """A coarser level's magnitudes at the places of a finer level's."""
    upright = np.ascontiguousarray(parent.T)
    size = (child.shape[1], child.shape[0])
    return cv2.resize(upright, size, interpolation=cv2.INTER_NEAREST).reshape(child.shape)
