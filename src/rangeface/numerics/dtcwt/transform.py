"""Forward and inverse transform, with complex coefficients."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import banded
from rangeface.numerics.dtcwt import quads, trees
from rangeface.numerics.dtcwt.levels import level

# which of the six orientations the sub-bands hl, lh, hh hold as (z₁, z₂): 15°, 45°, 75°, then
# their mirror images in reverse order
_ORIENTATIONS = ((2, 3), (0, 5), (1, 4))


class Pyramid(NamedTuple):
    """Coefficients of a dual-tree transform.

    Parameters
    ----------
    lowpass : (…, H', W') or (…, N') float32
        What the coarsest level leaves: both trees, interleaved.
    highpasses : tuple of (…, 6, h, w) or (…, n) complex64
        Per level, finest first. w = ⟨f, ψ_re⟩ + i ⟨f, ψ_im⟩ (eq. 3.2); its magnitude and phase
        (eq. 3.3, 3.4) are ``np.abs`` and ``np.angle``.
    shape : tuple of int
        Of the signal, without batch axes.
    first, further : str
        Filters.
    """

    lowpass: NDArray[np.float32]
    highpasses: tuple[NDArray[np.complex64], ...]
    shape: tuple[int, ...]
    first: str
    further: str


def forward_1d(
    signal: ArrayLike, *, levels: int = 4, first: str = "near_sym_a", further: str = "qshift_a"
) -> Pyramid:
    """Dual-tree complex wavelet transform of signals of any length.

    Parameters
    ----------
    signal : (…, N) array_like
        Finite; leading axes are a batch.
    levels : int
        ≥ 1.
    first : str
        Filters of level 1: "near_sym_a", "near_sym_b", or "selesnick" for Selesnick's pair of
        banks (periodic border).
    further : str
        Filters of the further levels: "qshift_06", "qshift_a", … "qshift_d".

    Returns
    -------
    Pyramid

    Raises
    ------
    ParameterError
        `levels` < 1, or an unknown filter.

    References
    ----------
    I. W. Selesnick, R. G. Baraniuk, N. G. Kingsbury, 2005, doi:10.1109/MSP.2005.1550194.

    Examples
    --------
    >>> pyramid = forward_1d(np.arange(100.0), levels=3)
    >>> [w.shape for w in pyramid.highpasses]
    [(50,), (25,), (13,)]
    """
    trees.check(levels, first, further)
    x = np.asarray(signal, dtype=np.float32)
    batch, length = x.shape[:-1], x.shape[-1]
    # a batch lies side by side: every signal is a column
    columns = np.ascontiguousarray(x.reshape(-1, length).T)
    highpasses = []
    for number in range(1, levels + 1):
        columns = trees.extended(columns, number, axes=(0,))
        step = level(number, len(columns), first, further)
        high = banded.apply(step.high, columns)
        columns = banded.apply(step.low, columns)
        highpasses.append((high[0::2] + 1j * high[1::2]).T.reshape(*batch, -1))
    lowpass = columns.T.reshape(*batch, -1)
    return Pyramid(lowpass, tuple(highpasses), (length,), first, further)


def inverse_1d(pyramid: Pyramid) -> NDArray[np.float32]:
    """Signals (…, N) float32 of their coefficients: the inverse of `forward_1d`."""
    lengths = trees.lengths(pyramid.shape[0], len(pyramid.highpasses))
    batch = pyramid.lowpass.shape[:-1]
    columns = np.ascontiguousarray(pyramid.lowpass.reshape(-1, pyramid.lowpass.shape[-1]).T)
    for number in range(len(lengths), 0, -1):
        length = lengths[number - 1]
        w = pyramid.highpasses[number - 1].reshape(columns.shape[1], -1).T
        high = np.empty((2 * len(w), columns.shape[1]), dtype=np.float32)
        high[0::2], high[1::2] = w.real, w.imag
        step = level(number, trees.padded(length, number), pyramid.first, pyramid.further)
        columns = banded.apply(step.low_back, columns)
        banded.accumulate(step.high_back, high, columns)
        before = trees.margin(length, number)
        columns = np.ascontiguousarray(columns[before : before + length])
    return columns.T.reshape(*batch, -1)


def forward_2d(
    image: ArrayLike, *, levels: int = 4, first: str = "near_sym_a", further: str = "qshift_a"
) -> Pyramid:
    """Dual-tree complex wavelet transform of images of any size.

    Parameters
    ----------
    image : (…, H, W) array_like
        Finite; leading axes are a batch.
    levels, first, further
        As in `forward_1d`.

    Returns
    -------
    Pyramid
        Six orientations a level, at 15°, 45°, 75°, −75°, −45° and −15°.

    Raises
    ------
    ParameterError
        `levels` < 1, an unknown filter, or fewer than two axes.

    References
    ----------
    I. W. Selesnick, R. G. Baraniuk, N. G. Kingsbury, 2005, doi:10.1109/MSP.2005.1550194.

    Examples
    --------
    >>> pyramid = forward_2d(np.ones((50, 77)), levels=2)
    >>> [w.shape for w in pyramid.highpasses], pyramid.lowpass.shape
    ([(6, 25, 39), (6, 13, 20)], (26, 40))
    """
    trees.check(levels, first, further)
    x = np.asarray(image, dtype=np.float32)
    if x.ndim < 2:
        raise ParameterError(f"image: expected (…, H, W), got {x.shape}")
    batch = x.shape[:-2]
    pyramids = [
        _pyramid(trees.analyse(one, levels, first, further)) for one in x.reshape(-1, *x.shape[-2:])
    ]
    lowpass = np.stack([p.lowpass for p in pyramids])
    highpasses = tuple(
        np.stack(parts) for parts in zip(*(p.highpasses for p in pyramids), strict=True)
    )
    return Pyramid(
        lowpass.reshape(*batch, *lowpass.shape[1:]),
        tuple(w.reshape(*batch, *w.shape[1:]) for w in highpasses),
        pyramids[0].shape,
        first,
        further,
    )


def inverse_2d(pyramid: Pyramid) -> NDArray[np.float32]:
    """Images (…, H, W) float32 of their coefficients: the inverse of `forward_2d`."""
    batch = pyramid.lowpass.shape[:-2]
    lowpasses = pyramid.lowpass.reshape(-1, *pyramid.lowpass.shape[-2:])
    highpasses = [w.reshape(-1, *w.shape[-3:]) for w in pyramid.highpasses]
    images = [
        trees.synthesise(
            _subbands(pyramid._replace(lowpass=low, highpasses=tuple(w[i] for w in highpasses)))
        )
        for i, low in enumerate(lowpasses)
    ]
    return np.stack(images).reshape(*batch, *pyramid.shape)


def _pyramid(bands: trees.Subbands) -> Pyramid:
    highpasses = []
    for number, detail in enumerate(bands.details, start=1):
        upright = _upright(detail, number)
        w = np.empty((6, *(n // 2 for n in upright[0].shape)), dtype=np.complex64)
        for (i, j), band in zip(_ORIENTATIONS, upright, strict=True):
            w[i], w[j] = quads.to_complex(band)
        highpasses.append(w)
    lowpass = bands.lowpass.T if len(bands.details) % 2 else bands.lowpass
    return Pyramid(
        np.ascontiguousarray(lowpass), tuple(highpasses), bands.shape, bands.first, bands.further
    )


def _subbands(pyramid: Pyramid) -> trees.Subbands:
    details = []
    for number, w in enumerate(pyramid.highpasses, start=1):
        lh, hl, hh = (quads.to_real(w[i], w[j]) for i, j in _ORIENTATIONS)
        details.append(_upright((lh, hl, hh), number))
    lowpass = pyramid.lowpass.T if len(details) % 2 else pyramid.lowpass
    return trees.Subbands(
        (pyramid.shape[0], pyramid.shape[1]),
        pyramid.first,
        pyramid.further,
        np.ascontiguousarray(lowpass),
        details,
    )


def _upright(detail: trees.Bands, number: int) -> trees.Bands:
    """Sub-bands lh, hl, hh of the image, from those of a level; its own inverse.

    An odd level left them transposed; an even level saw the image transposed, so that its first
    letter speaks of the horizontal.
    """
    lh, hl, hh = detail
    if number % 2:
        return tuple(np.ascontiguousarray(band.T) for band in detail)  # type: ignore[return-value]
    return hl, lh, hh
