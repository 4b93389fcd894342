from __future__ import annotations

import numpy as np

from rangeface.denoise import _check
from rangeface.denoise._noise import sigma_map
from rangeface.errors import ParameterError
from rangeface.numerics import smoothing
from rangeface.types import RangeImage


def anisotropic_diffusion(
    image: RangeImage, *, edge_factor: float = 3.0, iterations: int = 10, step: float = 0.2
) -> RangeImage:
    r"""Perona and Malik's diffusion: depth flows between neighbours unless they differ much.

    .. math:: \partial_t z = \operatorname{div}\!\left(e^{-(\|\nabla z\| / κ)^2} \nabla z\right),
              \qquad κ = kσ

    Parameters
    ----------
    image : RangeImage
        Any image; holes stay holes and nothing flows through them.
    edge_factor : float
        k > 0: a step of more than kσ counts as an edge.
    iterations : int
        ≥ 1; the width of the smoothing is about √(2 · step · iterations) px.
    step : float
        Time step, 0 … 0.25 (stability).

    Returns
    -------
    RangeImage
        σ as it was, an upper bound: the gain depends on the scene.

    Raises
    ------
    ParameterError
        A parameter is outside its range.

    References
    ----------
    P. Perona, J. Malik, IEEE TPAMI 12(7), 1990, doi:10.1109/34.56205.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> noise = np.random.default_rng(0).normal(0.0, 2.0, (80, 50))
    >>> image = RangeImage(500.0 + noise, Orthographic(2.8, 24.5, 39.5, 50, 80))
    >>> bool(np.std(anisotropic_diffusion(image).depth) < 1.0)
    True
    """
    _check.positive("edge_factor", edge_factor)
    if iterations < 1:
        raise ParameterError(f"iterations must be ≥ 1, got {iterations}")
    if not 0.0 < step <= 0.25:
        raise ParameterError(f"step must lie in 0 … 0.25, got {step}")
    edge = edge_factor * float(np.median(sigma_map(image)))
    if not image.mask.any() or edge <= 0.0:
        return image
    level = np.float32(np.nanmedian(image.depth))
    out = smoothing.diffused(image.depth - level, edge, iterations, step)
    return image.with_depth(out + level)
