"""Band-limited individual relief: the undulations that no named factor describes."""

from __future__ import annotations

import numpy as np

from rangeface.simulate._anatomy import Anatomy, Field, ramp

_WAVES = 48


def relief(
    anatomy: Anatomy,
    rms_mm: float,
    shortest_mm: float,
    longest_mm: float,
    *,
    rng: np.random.Generator,
) -> Field:
    r"""Random undulation of the face with wavelengths in a band, towards the camera.

    .. math:: d(x, y) = σ \sqrt{2/n} \sum_{i=1}^n \cos(k_i · (x, y) + φ_i)

    with random directions and phases and wavelengths 2π/|k| spread evenly in their logarithm:
    a Gaussian field in the limit of many waves.

    Parameters
    ----------
    anatomy : Anatomy
        The mean head.
    rms_mm : float
        Root mean square σ over people, mm.
    shortest_mm, longest_mm : float
        The band, mm.
    rng : numpy.random.Generator
        Source of the person's waves.

    Returns
    -------
    (n,) float64
        Height above the surface, mm; 0 behind the ears and on the neck.
    """
    length = shortest_mm * (longest_mm / shortest_mm) ** rng.random(_WAVES)
    direction, phase = 2.0 * np.pi * rng.random((2, _WAVES))
    k = 2.0 * np.pi / length * np.stack([np.cos(direction), np.sin(direction)])
    seen = (anatomy.front > 0) & (anatomy.level < 110.0)
    place = np.stack([anatomy.x[seen], anatomy.y[seen]], axis=-1).astype(np.float32)
    waves = place @ k.astype(np.float32) + phase.astype(np.float32)
    height = np.zeros(anatomy.x.shape)
    height[seen] = rms_mm * np.sqrt(2.0 / _WAVES) * np.cos(waves).sum(axis=1)
    return height * anatomy.front * ramp(-anatomy.level, -110.0, -84.0)
