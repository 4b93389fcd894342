"""The one resampling: an aligned face onto the frontal grid, with everything that it carries."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rangeface.errors import NoFaceError, ParameterError
from rangeface.io.reference import default_reference
from rangeface.numerics.normals import from_depth_orthographic
from rangeface.numerics.resample import inverse_variances, mirrored, moving_least_squares
from rangeface.types import (
    Alignment,
    Face,
    Float32,
    Orthographic,
    RangeImage,
    ReferenceFace,
    RigidTransform,
)

#: Where σ is unknown, every point counts alike.
_UNKNOWN_SIGMA_MM = 1.0


def resample(
    face: Face,
    alignment: Alignment,
    *,
    reference: ReferenceFace | None = None,
    width_mm: float = 140.0,
    height_mm: float = 224.0,
    width: int = 50,
    height: int = 80,
    radius_mm: float = 140.0,
    sigma_px: float = 1.0,
    fill: bool = True,
) -> RangeImage:
    """Resample a registered face to the frontal grid by weighted moving least squares.

    Points outside the sphere are dropped. Holes are filled by the mirrored half, then by the
    reference face, and marked in `filled`.

    Parameters
    ----------
    face : Face
        The crop, camera frame.
    alignment : Alignment
        Converged; its transform leads from the camera to the face frame.
    reference : ReferenceFace, optional
        Fills what neither half shows. Default: the reference that ships with the package.
    width_mm, height_mm : float
        Extent of the grid, mm, centred on the nose tip; both must give the same pitch.
    width, height : int
        Size of the grid, px.
    radius_mm : float
        Radius of the sphere crop around the nose tip, > 0.
    sigma_px : float
        Standard deviation of the window, grid pixels, > 0; widened where the camera's pixels
        are coarser than the grid's.
    fill : bool
        Leave holes as NaN if False.

    Returns
    -------
    RangeImage
        Orthographic, (height, width), nose tip at its centre, depth relative to the nose tip;
        with σ, amplitude and `filled`.

    Raises
    ------
    ParameterError
        Non-square pixels, or a radius or window ≤ 0.
    NoFaceError
        The alignment was refused, or no point falls onto the grid.

    References
    ----------
    P. Lancaster, K. Salkauskas, Math. Comp. 37, 1981, doi:10.1090/S0025-5718-1981-0616367-1.
    """
    if not radius_mm > 0:
        raise ParameterError(f"radius_mm must be > 0, got {radius_mm}")
    if not sigma_px > 0:
        raise ParameterError(f"sigma_px must be > 0, got {sigma_px}")
    if not alignment.converged:
        raise NoFaceError(f"cannot resample a refused alignment: {alignment.reason}")
    camera = grid(width_mm, height_mm, width, height)
    frontal = _splat(face, alignment.transform, camera, radius_mm, sigma_px)
    if not frontal.mask.any():
        raise NoFaceError("no point of the face falls onto the frontal grid")
    if not fill:
        return frontal
    return _filled(frontal, default_reference() if reference is None else reference)


def grid(width_mm: float, height_mm: float, width: int, height: int) -> Orthographic:
    """The frontal camera: `width` × `height` pixels over the given extent, nose tip at its centre.

    Parameters
    ----------
    width_mm, height_mm : float
        Extent, mm, > 0; both must give the same pitch within 1 %.
    width, height : int
        Pixels.

    Returns
    -------
    Orthographic

    Raises
    ------
    ParameterError
        The pitches in x and y differ by more than 1 %.

    Examples
    --------
    >>> grid(140.0, 224.0, 50, 80).pitch_mm
    2.8
    """
    return Orthographic.centred(width_mm, height_mm, width, height)


def incidence(frontal: RangeImage, face: Face, alignment: Alignment) -> Float32:
    r"""Cosine of the angle under which the camera's rays met the surface of a frontal image.

    .. math:: \cos θ = -n · \frac{p - c}{|p - c|}

    with the point p and the unit normal n of a pixel and the camera's centre c in the face frame;
    for a camera with parallel rays, their direction. 1 is head-on; a time-of-flight camera sees
    little of, and errs most on, what it looks along.

    Parameters
    ----------
    frontal : RangeImage
        As `resample` makes it.
    face : Face
        The crop that it was made of: gives the camera.
    alignment : Alignment
        The one that it was made with.

    Returns
    -------
    (H, W) float32
        0 … 1; NaN where there is no depth, or a filled one. A normal that noise turns away from
        the camera counts as 0.

    Raises
    ------
    ParameterError
        The image is not frontal: its camera is not orthographic.
    """
    camera = frontal.camera
    if not isinstance(camera, Orthographic):
        raise ParameterError("frontal: expected an image that `resample` made")
    depth = frontal.depth
    if frontal.filled is not None:
        depth = np.where(frontal.filled, np.float32(np.nan), depth)
    normals = from_depth_orthographic(depth, camera.pitch_mm)
    transform = alignment.transform
    if face.image.camera.projection.perspective:
        rays = camera.back_project(depth) - transform.translation
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    else:
        rays = np.broadcast_to(transform.rotation[:, 2], normals.shape)
    cosines = -np.einsum("ijk,ijk->ij", normals, rays)
    return np.clip(cosines, 0.0, 1.0).astype(np.float32)


def _splat(
    face: Face, transform: RigidTransform, camera: Orthographic, radius_mm: float, sigma_px: float
) -> RangeImage:
    image = face.image
    points = transform.apply(image.points[image.mask])
    inside = np.einsum("ij,ij->i", points, points) <= radius_mm**2
    columns_rows = camera.project(points[inside])
    scattered = np.column_stack([columns_rows, points[inside, 2]]).astype(np.float32)
    weights, values = _weights(image, inside), _amplitudes(image, inside)
    # a source pixel wider than the grid's pitch needs a window that reaches its neighbours
    spacing = image.camera.pixel_mm(float(np.linalg.norm(face.nose_tip))) / camera.pitch_mm
    window = np.float32(max(sigma_px, 0.8 * spacing))
    depth, variance, averages = moving_least_squares(
        scattered, weights, values, camera.height, camera.width, window, np.float32(0.3)
    )
    return RangeImage(
        depth=depth,
        camera=camera,
        sigma=None if image.sigma is None else np.sqrt(variance),
        amplitude=None if image.amplitude is None else averages[..., 0],
        filled=np.zeros(depth.shape, bool),
    )


def _weights(image: RangeImage, inside: np.ndarray) -> Float32:
    if image.sigma is None:
        return np.full(int(inside.sum()), 1.0 / _UNKNOWN_SIGMA_MM**2, np.float32)
    return inverse_variances(image.sigma[image.mask][inside])


def _amplitudes(image: RangeImage, inside: np.ndarray) -> Float32:
    if image.amplitude is None:
        return np.empty((int(inside.sum()), 0), np.float32)
    return np.nan_to_num(image.amplitude[image.mask][inside]).astype(np.float32)[:, None]


def _filled(frontal: RangeImage, reference: ReferenceFace) -> RangeImage:
    camera = frontal.camera
    assert isinstance(camera, Orthographic)
    depth, filled = frontal.depth.copy(), np.zeros(frontal.shape, bool)
    for source in (mirrored(frontal.depth, camera.cx), _reference_depth(reference, camera)):
        holes = ~np.isfinite(depth) & np.isfinite(source)
        depth[holes] = source[holes]
        filled |= holes
    return RangeImage(depth, camera, frontal.sigma, frontal.amplitude, filled)


@lru_cache(maxsize=16)
def _reference_depth(reference: ReferenceFace, camera: Orthographic) -> Float32:
    """The reference on the frontal grid; beyond its border, its own nearest depth."""
    from scipy.ndimage import distance_transform_edt

    points = reference.image.points[reference.image.mask]
    scattered = np.column_stack([camera.project(points), points[:, 2]]).astype(np.float32)
    pitch = reference.image.camera.pixel_mm(0.0)
    depth, _, _ = moving_least_squares(
        scattered, np.ones(len(points), np.float32), np.empty((len(points), 0), np.float32),
        camera.height, camera.width, np.float32(max(1.0, 0.8 * pitch / camera.pitch_mm)),
        np.float32(0.3),
    )  # fmt: skip
    rows, cols = distance_transform_edt(
        ~np.isfinite(depth), return_distances=False, return_indices=True
    )
    return depth[rows, cols]
