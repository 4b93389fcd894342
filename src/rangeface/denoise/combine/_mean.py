from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from rangeface.denoise.combine._frames import alike, divide, measured
from rangeface.types import RangeImage, RigidTransform


def mean(
    frames: Iterable[RangeImage], *, poses: Sequence[RigidTransform] | None = None
) -> RangeImage:
    r"""Mean of the frames' depths, pixel by pixel, over those that measured it.

    .. math:: \bar z = \frac{1}{n} \sum_k z_k, \qquad σ^2 = \frac{1}{n^2} \sum_k σ_k^2

    Parameters
    ----------
    frames : iterable of RangeImage
        At least one, all of one camera; read once, one held at a time.
    poses : sequence of RigidTransform, optional
        Not used: the head is taken to be still.

    Returns
    -------
    RangeImage
        σ and amplitude (mean) where every frame has them. A pixel that no frame measured is
        invalid; what frames merely filled in does not count.

    Raises
    ------
    ParameterError
        There is no frame, or the cameras differ.

    Examples
    --------
    >>> from rangeface.types import Pinhole
    >>> camera = Pinhole(200, 200, 0, 0, 1, 1)
    >>> out = mean(RangeImage([[z]], camera, sigma=[[2.0]]) for z in (399.0, 401.0, np.nan))
    >>> float(out.depth[0, 0]), round(float(out.sigma[0, 0]), 3)
    (400.0, 1.414)
    """
    del poses
    count = depth = amplitude = variance = np.zeros(())
    has_sigma = has_amplitude = True
    for frame in alike(frames):
        seen = measured(frame)
        count = count + seen
        depth = depth + np.where(seen, frame.depth, 0.0)
        has_sigma &= frame.sigma is not None
        has_amplitude &= frame.amplitude is not None
        if frame.sigma is not None:
            variance = variance + np.where(seen, frame.sigma.astype(np.float64) ** 2, 0.0)
        if frame.amplitude is not None:
            amplitude = amplitude + np.where(seen, frame.amplitude, 0.0)
    return frame.with_depth(
        divide(depth, count),
        sigma=divide(np.sqrt(variance), count) if has_sigma else None,
        amplitude=divide(amplitude, count) if has_amplitude else None,
        filled=None,
    )
