from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._confidence import amplitude_of
from rangeface.denoise.combine._frames import alike, divide, measured
from rangeface.types import Float64, RangeImage, RigidTransform

_LIGHT_MM_PER_S = 299_792_458_000.0
# a measured pixel of unknown amplitude has the last word only where nobody else speaks
_LEAST_AMPLITUDE = 1e-6


def phasor_mean(
    frames: Iterable[RangeImage],
    *,
    frequency_hz: float = 20.0e6,
    poses: Sequence[RigidTransform] | None = None,
) -> RangeImage:
    r"""Mean of time-of-flight frames as phasors: what one longer exposure would have measured.

    .. math:: P = \sum_k A_k e^{i φ_k}, \quad φ_k = \frac{4π f}{c} r_k, \quad
              r = \frac{c}{4π f} \arg P

    Parameters
    ----------
    frames : iterable of RangeImage
        At least one, all of one camera; read once, one held at a time.
    frequency_hz : float
        Modulation frequency f, Hz, > 0. The unambiguous range is c / 2f.
    poses : sequence of RigidTransform, optional
        Not used: the head is taken to be still.

    Returns
    -------
    RangeImage
        The amplitude is |P| / n, the coherent mean. σ² = Σ A²σ² / (Σ A)², where every frame
        has σ. What frames merely filled in does not count.

    Raises
    ------
    ParameterError
        There is no frame, the cameras differ, or the frequency is not positive.

    Notes
    -----
    A phase measures the *radial* range r: depth is turned into it and back. The phasor names r
    only up to multiples of c / 2f; of these, the one nearest to the frames' mean range is
    taken, so that data beyond the first period (several frequencies) keep theirs. Without an
    amplitude 1/σ weighs the frames, and without σ they count alike.

    References
    ----------
    M. Frank et al., Optical Engineering 48(1), 2009, doi:10.1117/1.3070634.

    Examples
    --------
    The weak frame, whose range wrapped around, hardly counts:

    >>> from rangeface.types import Pinhole
    >>> camera = Pinhole(200, 200, 0, 0, 1, 1)
    >>> strong = RangeImage([[400.0]], camera, amplitude=[[90.0]])
    >>> weak = RangeImage([[7000.0]], camera, amplitude=[[10.0]])
    >>> round(float(phasor_mean([strong, strong, weak]).depth[0, 0]))
    357
    """
    del poses
    _check.positive("frequency_hz", frequency_hz)
    wave_number = 4.0 * np.pi * frequency_hz / _LIGHT_MM_PER_S
    phasor = weight = centre = count = variance = np.zeros(())
    has_sigma = has_amplitude = True
    for frame in alike(frames):
        seen = measured(frame)
        A = np.where(seen, np.maximum(amplitude_of(frame), _LEAST_AMPLITUDE), 0.0)
        r = np.where(seen, frame.depth * frame.camera.radial_factor().astype(np.float64), 0.0)
        phasor = phasor + A * np.exp(1j * wave_number * r)
        centre = centre + A * r
        weight = weight + A
        count = count + seen
        has_amplitude &= frame.amplitude is not None
        has_sigma &= frame.sigma is not None
        if frame.sigma is not None:
            variance = variance + np.where(A > 0, (A * frame.sigma.astype(np.float64)) ** 2, 0.0)
    radial = _nearest_range(phasor, divide(centre, weight), wave_number)
    return frame.with_depth(
        radial / frame.camera.radial_factor(),
        sigma=divide(np.sqrt(variance), weight) if has_sigma else None,
        amplitude=divide(np.abs(phasor), count) if has_amplitude else None,
        filled=None,
    )


def _nearest_range(phasor: Float64, centre: Float64, wave_number: float) -> Float64:
    """Range of a phasor, out of its many the one nearest to `centre`."""
    turn = np.angle(phasor * np.exp(-1j * wave_number * centre))
    return centre + turn / wave_number
