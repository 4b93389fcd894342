"""Residual of two faces after the small motion that registration left between them."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.classify._base import Float32, Matcher
from rangeface.errors import ParameterError
from rangeface.numerics.surfaces import surface_losses, surface_residuals

#: Ellipse of the face around 12 mm above the nose tip, mm to either side and up or down.
_HALF_WIDTH_MM, _HALF_HEIGHT_MM, _CENTRE_MM = 62.0, 85.0, -12.0
#: No surface lies further from the nose tip.
_FAR_MM = 1e4
#: Where each region ends below the nose tip, mm: nostrils, or the whole face.
REGIONS = {"face": np.inf, "upper": 8.0}


class SurfaceMatcher(Matcher):
    r"""Iterative closest points as a matcher: how well two surfaces fit once they are aligned.

    .. math:: s(p, g) = -\min_{R, t} \frac{1}{K} \sum_{k=1}^{K} ρ\big(n_k · (q_k - R p_k - t)\big)

    Parameters
    ----------
    region : {"upper", "face"}
        What is compared: from the nostrils upwards, or the whole face. The upper face is
        steadier under expression.
    width : int
        Columns of the frontal image, ≥ 2.
    pitch_mm : float
        Edge of its pixels, > 0.
    scale_mm : float
        Residuals well beyond it count as unlike, whatever their size, > 0.
    missing : float
        Loss of a probe's pixel for which the gallery has no surface, 0 … 1.

    Raises
    ------
    ParameterError
        A parameter is out of range, or a sample is not finite or of another width.

    Notes
    -----
    Nothing is learned. Samples are those of ``describe.surface``: pairs of depth and inverse
    variance, row by row; a value that has no partner and an unfinished row are left out and
    filled with holes. Cost: O(people × pixels × iterations), about 30 µs a pair, so a pipeline
    asks it about a shortlist only. It aligns by itself: a template needs one row, not the
    rotated views. **Its template is a relief of the face**: treat it like a picture of the person
    (a gallery can encrypt it), or use a preset without this head.

    References
    ----------
    P. Besl, N. McKay, IEEE TPAMI 14(2), 1992, doi:10.1109/34.121791; regions: T. Faltemier,
    K. Bowyer, P. Flynn, IEEE Trans. Inf. Forensics Secur. 3(1), 2008,
    doi:10.1109/TIFS.2007.916287.

    Examples
    --------
    A bowl moved by 2 mm against itself (the rim has no counterpart) and against a flatter one:

    >>> y, x = np.mgrid[-20:20.0, -12:13.0] * 3
    >>> bowls = [np.stack([c * (x**2 + y**2), np.ones_like(x)], -1).ravel() for c in (0.01, 0.004)]
    >>> moved = np.stack([0.01 * (x**2 + y**2) + 2, np.ones_like(x)], -1).ravel()
    >>> matcher = SurfaceMatcher(width=25, pitch_mm=3.0).fit(bowls)
    >>> matcher.similarity([moved], bowls).round(1)
    array([[-0.1, -0.4]], dtype=float32)
    """

    needs_rotated_views = False
    pairwise = True

    def __init__(
        self,
        *,
        region: str = "upper",
        width: int = 50,
        pitch_mm: float = 2.8,
        scale_mm: float = 3.0,
        missing: float = 0.6,
    ) -> None:
        self.region = region
        self.width = width
        self.pitch_mm = pitch_mm
        self.scale_mm = scale_mm
        self.missing = missing

    def fit(self, X: ArrayLike, y: object = None) -> Self:
        """Check samples X (N, m) in rows; y is ignored."""
        if self.region not in REGIONS:
            raise ParameterError(f"region: unknown {self.region!r}; known are {', '.join(REGIONS)}")
        if not (isinstance(self.width, int | np.integer) and self.width >= 2):
            raise ParameterError(f"width: must be an int ≥ 2, got {self.width!r}")
        for name in ("pitch_mm", "scale_mm"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ParameterError(f"{name}: must be > 0, got {value}")
        if not 0 <= self.missing <= 1:
            raise ParameterError(f"missing: must be in 0 … 1, got {self.missing}")
        self._samples(X)
        return self

    def transform(self, X: ArrayLike) -> Float32:
        """Samples (n, m) to half precision (0.06 mm at 100 mm), so that files stay small."""
        samples = np.clip(self._fitted_samples(X), -_FAR_MM, _FAR_MM).astype(np.float32)
        return np.ldexp(np.ldexp(samples, -8).astype(np.float16).astype(np.float32), 8)

    def similarity(self, probes: ArrayLike, gallery: ArrayLike) -> Float32:
        """Scores (n, m) of transformed probes against a transformed gallery: −1 … 0."""
        P, G = self._surfaces(probes), self._surfaces(gallery)
        return -surface_losses(
            P, G, self._pixels(P.shape[1]),
            pitch_mm=self.pitch_mm, scale_mm=self.scale_mm, missing=self.missing,
        )  # fmt: skip

    def residuals(self, probe: ArrayLike, gallery: ArrayLike) -> Float32:
        """Where one transformed row differs from another, (H, W) mm, once their region is aligned.

        Positive: the gallery's surface lies behind the probe's. NaN: one of them has none.
        """
        (P,), (G,) = self._surfaces(np.atleast_2d(probe)), self._surfaces(np.atleast_2d(gallery))
        return surface_residuals(
            P, G, self._pixels(len(P)), pitch_mm=self.pitch_mm, scale_mm=self.scale_mm
        )

    def _surfaces(self, rows: ArrayLike) -> Float32:
        """Rows (n, m) as surfaces (n, H, W, 2); a full grid is not copied."""
        flat = np.ascontiguousarray(rows, dtype=np.float32)
        if flat.ndim != 2:
            raise ParameterError(f"probes, gallery: expected (n, m), got {flat.shape}")
        line = 2 * self.width
        lines = max(flat.shape[1] // line, 2)
        if flat.shape[1] != lines * line:
            kept = min(flat.shape[1], lines * line) // 2 * 2
            padded = np.zeros((len(flat), lines * line), np.float32)
            padded[:, :kept] = flat[:, :kept]
            flat = padded
        return flat.reshape(len(flat), lines, self.width, 2)

    def _pixels(self, height: int) -> NDArray[Any]:
        """Every second pixel of the region in both directions: rows and columns, (k, 2)."""
        rows, cols = np.mgrid[:height:2, : self.width : 2]
        x = (cols - 0.5 * (self.width - 1)) * self.pitch_mm
        y = (rows - 0.5 * (height - 1)) * self.pitch_mm
        ellipse = (x / _HALF_WIDTH_MM) ** 2 + ((y - _CENTRE_MM) / _HALF_HEIGHT_MM) ** 2 < 1.0
        inside = ellipse & (y < REGIONS[self.region])
        return np.column_stack([rows[inside], cols[inside]])
