"""Calibration of one specimen from captures of a plane: offset map, wiggling curve, gain map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from rangeface.errors import DegenerateError, ParameterError, ScanError, ScanFault
from rangeface.types import Float32, Float64, RangeImage

_ROUNDS = 12  # of the alternation between map and curve; it converges by a factor a round
_FIELDS = ("offset_mm", "range_mm", "wiggle_mm", "gain")


@dataclass(frozen=True, eq=False)
class Calibration:
    """Systematic errors of one specimen.

    Parameters
    ----------
    offset_mm : (H, W) array
        Each pixel's own error of the radial range, mm; NaN where it was never seen.
    range_mm, wiggle_mm : (k,) array
        Error common to all pixels at the knots of the measured range, mm; linear between them.
    gain : (H, W) array
        Amplitude of each pixel relative to the inverse-square law, mean 1.
    """

    offset_mm: Float32
    range_mm: Float64
    wiggle_mm: Float64
    gain: Float32

    def apply(self, image: RangeImage) -> RangeImage:
        """The image with the errors taken out.

        Parameters
        ----------
        image : RangeImage
            Capture of the same specimen.

        Returns
        -------
        RangeImage
            Corrected depth, and amplitude where there is one.

        Raises
        ------
        ParameterError
            The image has another size.
        """
        if image.shape != self.offset_mm.shape:
            raise ParameterError(
                f"image: shape {image.shape} is not the calibration's {self.offset_mm.shape}"
            )
        ray = image.camera.radial_factor()
        radial = image.depth.astype(np.float64) * ray
        error = self.offset_mm + np.interp(radial, self.range_mm, self.wiggle_mm)
        corrected = image.with_depth((radial - error) / ray)
        if image.amplitude is None:
            return corrected
        amplitude: Float32 = np.asarray(image.amplitude / np.maximum(self.gain, 1e-3), np.float32)
        return replace(corrected, amplitude=amplitude)

    def save(self, path: str | Path) -> None:
        """Write one npz file of four arrays.

        Parameters
        ----------
        path : str or Path
            File to write.
        """
        with Path(path).open("wb") as file:
            np.savez_compressed(file, **{name: getattr(self, name) for name in _FIELDS})

    @classmethod
    def load(cls, path: str | Path) -> Calibration:
        """Read what `save` wrote.

        Parameters
        ----------
        path : str or Path
            File to read.

        Returns
        -------
        Calibration

        Raises
        ------
        ScanError
            The file is missing or is no calibration.
        """
        if not Path(path).is_file():
            raise ScanError(path, ScanFault.MISSING)
        try:
            with np.load(path, allow_pickle=False) as arrays:
                return cls(**{name: arrays[name] for name in _FIELDS})
        except (KeyError, ValueError, OSError) as error:
            raise ScanError(path, ScanFault.MALFORMED, f"not a calibration: {error}") from error


def calibrate(
    frames: Sequence[RangeImage], distances_mm: ArrayLike, *, knot_mm: float = 40.0
) -> Calibration:
    r"""Estimate a specimen's systematic errors from captures of a frontal plane.

    .. math:: d_i(u, v) = r_i(u, v) + o(u, v) + w(d_i), \qquad r_i = z_i \,\|ray(u, v)\|

    The map o and the curve w are found by alternating averages; w has mean 0.

    Parameters
    ----------
    frames : sequence of RangeImage
        One capture (better: the mean of many) of the plane at each distance; at least 2.
    distances_mm : (n,) array_like
        True depth z of the plane, mm.
    knot_mm : float
        Spacing of the curve's knots, mm, > 0; a wiggle needs several knots per period.

    Returns
    -------
    Calibration
        Map, curve and gain.

    Raises
    ------
    ParameterError
        As many distances as frames are not given, or the spacing is not positive.
    DegenerateError
        Fewer than two frames, or no pixel is valid in two of them.

    References
    ----------
    M. Lindner, A. Kolb, LNCS 4292, 2006, doi:10.1007/11919629_53 (wiggling as a curve of range).
    """
    distances = np.asarray(distances_mm, np.float64)
    if distances.shape != (len(frames),):
        raise ParameterError(f"distances_mm: {distances.shape} for {len(frames)} frames")
    if not knot_mm > 0:
        raise ParameterError(f"knot_mm: must be > 0, got {knot_mm}")
    if len(frames) < 2:
        raise DegenerateError("calibrate: at least two distances are needed")
    ray = frames[0].camera.radial_factor()
    radial = np.stack([frame.depth * ray for frame in frames]).astype(np.float64)
    error = radial - distances[:, None, None] * ray
    seen = np.isfinite(error)
    if (seen.sum(axis=0) >= 2).sum() == 0:
        raise DegenerateError("calibrate: no pixel is valid in two frames")
    low, high = radial[seen].min(), radial[seen].max()
    knots = np.linspace(low, high, max(2, 1 + round((high - low) / knot_mm)))
    offset, wiggle = _alternate(radial, error, seen, knots)
    return Calibration(offset, knots, wiggle, _gain(frames, distances, ray))


def _alternate(
    radial: Float64, error: Float64, seen: Float64, knots: Float64
) -> tuple[Float32, Float64]:
    position = np.interp(radial[seen], knots, np.arange(len(knots), dtype=np.float64))
    left = np.minimum(position.astype(np.intp), len(knots) - 2)
    right_share = position - left
    _, row, column = np.nonzero(seen)
    pixel = row * radial.shape[2] + column
    counts = np.bincount(pixel, minlength=radial[0].size)
    offset, wiggle = np.zeros(radial[0].size), np.zeros(len(knots))
    for _ in range(_ROUNDS):
        curve = (1.0 - right_share) * wiggle[left] + right_share * wiggle[left + 1]
        total = np.bincount(pixel, error[seen] - curve, minlength=radial[0].size)
        offset = total / np.maximum(counts, 1)
        wiggle = _hats(error[seen] - offset[pixel], left, right_share, len(knots))
        wiggle -= wiggle.mean()
    offset[counts == 0] = np.nan
    return offset.reshape(radial.shape[1:]).astype(np.float32), wiggle


def _hats(values: Float64, left: Float64, right_share: Float64, knots: int) -> Float64:
    """Least squares of a piecewise linear curve: normal equations of the hat functions."""
    a, b = 1.0 - right_share, right_share
    normal = np.zeros((knots, knots))
    i = np.arange(knots - 1)
    normal[i, i + 1] = normal[i + 1, i] = np.bincount(left, a * b, minlength=knots)[:-1]
    normal[np.arange(knots), np.arange(knots)] = 1e-9 + (
        np.bincount(left, a * a, minlength=knots) + np.bincount(left + 1, b * b, minlength=knots)
    )
    right = np.bincount(left, a * values, minlength=knots)
    right += np.bincount(left + 1, b * values, minlength=knots)
    return np.asarray(np.linalg.solve(normal, right), np.float64)


def _gain(frames: Sequence[RangeImage], distances: Float64, ray: Float32) -> Float32:
    laws = [
        frame.amplitude * (z * ray) ** 2
        for frame, z in zip(frames, distances, strict=True)
        if frame.amplitude is not None
    ]
    if not laws:
        return np.ones(ray.shape, np.float32)
    law = np.mean(laws, axis=0)
    return np.asarray(law / law.mean(), np.float32)
