"""A clean scan made worse, step by step, down to the quality of a time-of-flight camera."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import distance_transform_edt

from rangeface.errors import ParameterError
from rangeface.numerics import draws
from rangeface.types import Orthographic, Pinhole, RangeImage


def add_noise(image: RangeImage, sigma_mm: float, *, rng: np.random.Generator) -> RangeImage:
    """Gaussian noise of `sigma_mm` (mm, ≥ 0) on every valid pixel.

    Raises
    ------
    ParameterError
        The deviation is negative.

    Examples
    --------
    >>> flat = RangeImage(np.full((100, 100), 400.0), Orthographic(1.0, 0, 0, 100, 100))
    >>> noisy = add_noise(flat, 2.0, rng=np.random.default_rng(0))
    >>> bool(abs(noisy.depth.std() - 2.0) < 0.05)
    True
    """
    if not sigma_mm >= 0:
        raise ParameterError(f"sigma_mm: must be ≥ 0, got {sigma_mm}")
    known = np.zeros(image.shape, np.float32) if image.sigma is None else image.sigma
    noisy = image.depth + np.float32(sigma_mm) * draws.normal(image.shape, rng=rng)
    return image.with_depth(noisy, sigma=np.hypot(known, np.float32(sigma_mm)))


def add_noise_psnr(
    image: RangeImage, psnr_db: float, *, peak_mm: float, rng: np.random.Generator
) -> RangeImage:
    r"""Gaussian noise at a given peak signal-to-noise ratio.

    .. math:: \mathrm{PSNR} = 20 \log_{10} (\mathrm{peak} / σ)

    Parameters
    ----------
    image : RangeImage
        Clean scan.
    psnr_db : float
        dB.
    peak_mm : float
        Depth range that the peak stands for, mm, > 0 (the source paper: 255 levels = 140 mm).
    rng : numpy.random.Generator
        Source of the noise.

    Returns
    -------
    RangeImage
        Noisy scan with its σ.

    Raises
    ------
    ParameterError
        The peak is not positive, or the ratio is not finite.
    """
    if not peak_mm > 0:
        raise ParameterError(f"peak_mm: must be > 0, got {peak_mm}")
    if not np.isfinite(psnr_db):
        raise ParameterError(f"psnr_db: must be finite, got {psnr_db}")
    return add_noise(image, peak_mm * 10.0 ** (-psnr_db / 20.0), rng=rng)


def coarsen(image: RangeImage, factor: int) -> RangeImage:
    """Resolution divided by `factor`: the mean of the valid pixels of every block.

    A block less than half of which is valid becomes invalid; rows and columns that fill no block
    are cut off.

    Raises
    ------
    ParameterError
        The factor is below 1 or larger than the image.
    """
    if factor < 1 or factor > min(image.shape):
        raise ParameterError(f"factor: must lie in 1 … {min(image.shape)}, got {factor}")
    height, width = (n // factor for n in image.shape)
    cut = image.depth[: height * factor, : width * factor].astype(np.float64)
    blocks = cut.reshape(height, factor, width, factor)
    valid = np.isfinite(blocks).sum(axis=(1, 3))
    total = np.nansum(blocks, axis=(1, 3))
    depth = np.where(2 * valid >= factor**2, total / np.maximum(valid, 1), np.nan)
    c = image.camera
    cx, cy = ((p - 0.5 * (factor - 1)) / factor for p in (c.cx, c.cy))
    camera: Pinhole | Orthographic
    if isinstance(c, Pinhole):
        camera = Pinhole(c.fx / factor, c.fy / factor, cx, cy, width, height)
    else:
        camera = Orthographic(c.pitch_mm * factor, cx, cy, width, height)
    return RangeImage(depth.astype(np.float32), camera)


def quantise(image: RangeImage, step_mm: float) -> RangeImage:
    """Depth rounded to multiples of `step_mm` (mm, > 0).

    Raises
    ------
    ParameterError
        The step is not positive.
    """
    if not step_mm > 0:
        raise ParameterError(f"step_mm: must be > 0, got {step_mm}")
    return image.with_depth(np.round(image.depth / step_mm) * step_mm)


def punch_holes(
    image: RangeImage, share: float, *, radius_px: float = 1.5, rng: np.random.Generator
) -> RangeImage:
    """Round holes that cover about `share` (0 … 1) of the image.

    Raises
    ------
    ParameterError
        The share is outside 0 … 1, or the radius is not positive.
    """
    if not 0 <= share <= 1:
        raise ParameterError(f"share: must lie in 0 … 1, got {share}")
    if not radius_px > 0:
        raise ParameterError(f"radius_px: must be > 0, got {radius_px}")
    if share == 1:
        return image.masked(np.zeros(image.shape, bool))
    height, width = image.shape
    reach = np.arange(-np.ceil(radius_px), np.ceil(radius_px) + 1)
    area = int((np.hypot(reach[:, None], reach) <= radius_px).sum())
    # discs thrown at random overlap: n of them leave exp(−n · area / size) uncovered
    count = round(-np.log1p(-share) * height * width / area)
    centres = np.zeros(image.shape, bool)
    centres[rng.integers(0, height, count), rng.integers(0, width, count)] = True
    if not centres.any():
        return image
    return image.masked(distance_transform_edt(~centres) > radius_px)


def degrade(
    image: RangeImage,
    *,
    pitch_mm: float = 2.0,
    step_mm: float = 1.0,
    sigma_mm: float = 4.0,
    holes: float = 0.02,
    rng: np.random.Generator,
) -> dict[str, RangeImage]:
    """From a clean scan to time-of-flight quality, every step on top of the one before.

    Parameters
    ----------
    image : RangeImage
        Clean scan, finer than `pitch_mm`.
    pitch_mm : float
        Width of a pixel on the face in the end, mm (SR-3000 at 40 cm: about 2).
    step_mm, sigma_mm, holes : float
        As in `quantise`, `add_noise` and `punch_holes`.
    rng : numpy.random.Generator
        Source of noise and holes.

    Returns
    -------
    dict of str to RangeImage
        "original", "resolution", "noise", "quantisation", "holes".

    Raises
    ------
    ParameterError
        As in the steps; `pitch_mm` not positive; no valid pixel.
    """
    if not pitch_mm > 0:
        raise ParameterError(f"pitch_mm: must be > 0, got {pitch_mm}")
    if not image.mask.any():
        raise ParameterError("image: no valid pixel")
    own = image.camera.pixel_mm(float(np.nanmedian(image.depth)))
    coarse = coarsen(image, max(1, round(pitch_mm / own)))
    noisy = add_noise(coarse, sigma_mm, rng=rng)
    rounded = quantise(noisy, step_mm)
    return {
        "original": image,
        "resolution": coarse,
        "noise": noisy,
        "quantisation": rounded,
        "holes": punch_holes(rounded, holes, rng=rng),
    }
