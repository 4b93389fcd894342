"""What a scan file is, for a person who asks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rangeface.io._formats import FORMATS
from rangeface.io._read import open_scan
from rangeface.io._source import Limits
from rangeface.types import Camera, Orthographic, RangeImage


@dataclass(frozen=True, eq=False)
class Description:
    """A scan file in figures.

    Parameters
    ----------
    path : Path
        The file.
    format : str
        Name of the format, a key of FORMATS.
    title : str
        The format in words.
    size_bytes : int
        Size of the file.
    unit : str
        Unit of the file's lengths: as the caller, the format or a camera file states it.
    image : RangeImage
        The scan itself.
    near_mm, far_mm : float
        Smallest and largest depth, mm.
    valid : int
        Valid pixels.
    sigma_mm : float
        Median standard deviation of the depth as the file or its sensor's model states it, mm;
        NaN where neither does.
    noise_mm : float
        Estimate from the image itself, mm (see Notes); NaN where too few pixels are valid.

    Notes
    -----
    The noise estimate is the median absolute value of the mask (1 −2 1; −2 4 −2; 1 −2 1), which
    a plane and any surface that is quadratic along rows or columns leave at zero, divided by
    6 · 0.6745. Structure that is finer than three pixels raises it.

    References
    ----------
    J. Immerkær, Fast noise variance estimation, CVIU 64(2), 1996, doi:10.1006/cviu.1996.0060.
    """

    path: Path
    format: str
    title: str
    size_bytes: int
    unit: str
    image: RangeImage
    near_mm: float
    far_mm: float
    valid: int
    sigma_mm: float
    noise_mm: float

    def lines(self) -> list[tuple[str, str]]:
        """Names and values, ready to be printed one below the other."""
        height, width = self.image.shape
        planes = [n for n in ("sigma", "amplitude", "filled") if getattr(self.image, n) is not None]
        sigma = "not stated" if np.isnan(self.sigma_mm) else f"{self.sigma_mm:.2f} mm, as stated"
        noise = "too few pixels" if np.isnan(self.noise_mm) else f"{self.noise_mm:.2f} mm"
        return [
            ("file", f"{self.path} ({self.size_bytes:,} bytes)"),
            ("format", f"{self.title} [{self.format}]"),
            ("unit", self.unit),
            ("image", f"{width} × {height} px, {_camera_words(self.image.camera)}"),
            ("depth", f"{self.near_mm:.1f} … {self.far_mm:.1f} mm"),
            ("valid pixels", f"{self.valid:,} ({100 * self.valid / (width * height):.1f} %)"),
            ("noise", f"σ {sigma}; {noise} estimated from the image"),
            ("planes", ", ".join(["depth", *planes])),
        ]


def describe_scan(
    path: str | Path,
    *,
    camera: Camera | None = None,
    unit: str | None = None,
    front: str | None = None,
    up: str | None = None,
    pitch_mm: float = 1.5,
    limits: Limits | None = None,
) -> Description:
    """Read a scan and say what it is: format, size, unit, range, valid pixels, noise.

    Parameters
    ----------
    path, camera, unit, front, up, pitch_mm, limits
        As in `read_scan`.

    Returns
    -------
    Description
        `lines()` are ready to be printed.

    Raises
    ------
    ScanError
        As in `read_scan`.
    ParameterError
        As in `read_scan`.
    """
    source, name, image = open_scan(
        path, camera=camera, unit=unit, front=front, up=up, pitch_mm=pitch_mm, limits=limits
    )
    depth = image.depth[image.mask]
    sigma = float("nan") if image.sigma is None else float(np.nanmedian(image.sigma[image.mask]))
    return Description(
        path=Path(path),
        format=name,
        title=FORMATS[name].title,
        size_bytes=Path(path).stat().st_size,
        unit=source.unit or FORMATS[name].unit or "as the camera file states",
        image=image,
        near_mm=float(depth.min()),
        far_mm=float(depth.max()),
        valid=int(image.mask.sum()),
        sigma_mm=sigma,
        noise_mm=estimate_noise(image.depth),
    )


def estimate_noise(depth: NDArray[np.float32]) -> float:
    """Standard deviation of independent noise in a depth image (H, W), mm, by Immerkær's mask."""
    d = depth.astype(np.float64)
    rows = d[:-2] - 2 * d[1:-1] + d[2:]
    mask = rows[:, :-2] - 2 * rows[:, 1:-1] + rows[:, 2:]
    known = np.abs(mask[np.isfinite(mask)])
    return float(np.median(known) / (6.0 * 0.6745)) if len(known) >= 32 else float("nan")


def _camera_words(camera: Camera) -> str:
    if isinstance(camera, Orthographic):
        return f"orthographic, {camera.pitch_mm:g} mm a pixel"
    return f"f = {camera.fx:.1f}, {camera.fy:.1f} px, c = {camera.cx:.1f}, {camera.cy:.1f} px"
