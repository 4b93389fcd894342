"""What a camera would see without noise: heads and other surfaces through a z-buffer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import zbuffer
from rangeface.numerics.se3 import head_rotation
from rangeface.simulate._head import SHINE, Head
from rangeface.types import (
    Camera,
    Float32,
    Orthographic,
    Pinhole,
    PointSet,
    RangeImage,
    RigidTransform,
)

_GREY = 0.5  # reflectivity of a surface that states none


@dataclass(frozen=True, eq=False)
class Scene:
    """A noise-free view: depth, normal and reflectivity per sample.

    Parameters
    ----------
    camera : Pinhole or Orthographic
        Of the image; the planes below are `oversample` times finer.
    depth : (kH, kW) float32
        z, mm; NaN where nothing is seen.
    normal : (kH, kW, 3) float32
        Unit normal, towards the camera.
    reflectivity : (kH, kW) float32
        0 … 1.
    shine : (kH, kW) float32
        Strength of the mirror-like reflection: eyes and spectacle lenses.
    part : (kH, kW) int16
        Which of the rendered surfaces is seen; −1 where none.
    triangle : (kH, kW) int32
        Which of its triangles.
    oversample : int
        k: samples per pixel and direction.
    """

    camera: Camera
    depth: Float32
    normal: Float32
    reflectivity: Float32
    shine: Float32
    part: NDArray[np.int16]
    triangle: NDArray[np.int32]
    oversample: int = 1

    @property
    def fine_camera(self) -> Camera:
        """Camera of the planes."""
        return _refined(self.camera, self.oversample)

    @property
    def image(self) -> RangeImage:
        """The clean range image: the sample nearest to each pixel's centre."""
        middle = slice(self.oversample // 2, None, self.oversample)
        return RangeImage(self.depth[middle, middle], self.camera)


def pose(
    *,
    yaw_deg: float = 0.0,
    pitch_deg: float = 0.0,
    roll_deg: float = 0.0,
    nose_tip_mm: tuple[float, float, float] = (0.0, 0.0, 400.0),
) -> RigidTransform:
    """Pose of a head before the camera.

    Parameters
    ----------
    yaw_deg, pitch_deg, roll_deg : float
        Positive yaw turns the face to the right of the image, positive pitch down, positive
        roll tilts it clockwise in the image.
    nose_tip_mm : tuple of float
        Where the nose tip is, camera frame, mm.

    Returns
    -------
    RigidTransform
        T_camera_face.

    Examples
    --------
    >>> pose(yaw_deg=90.0).apply([0.0, 0.0, -1.0]).round(6) + 0.0
    array([  1.,   0., 400.])
    """
    angles = np.radians([yaw_deg, pitch_deg, roll_deg])
    return RigidTransform(
        head_rotation(*angles), np.array(nose_tip_mm), target="camera", source="face"
    )


def render(
    surfaces: Head | PointSet | Sequence[Head | PointSet],
    camera: Camera,
    poses: RigidTransform | Sequence[RigidTransform | None] | None = None,
    *,
    oversample: int = 1,
) -> Scene:
    """View of one or several surfaces, nearest first per pixel.

    Parameters
    ----------
    surfaces : Head, PointSet or sequence of them
        Surfaces with triangles.
    camera : Pinhole or Orthographic
        Camera.
    poses : RigidTransform or sequence of them, optional
        T_camera_face of each surface; None: it is in the camera frame already (default).
    oversample : int
        Samples per pixel and direction, odd, ≥ 1; 3 or 5 lets `tof` mix light inside a pixel.

    Returns
    -------
    Scene
        Exact on planar triangles (see `rangeface.numerics.zbuffer`).

    Raises
    ------
    ParameterError
        A surface without triangles, as many poses as surfaces are not given, or `oversample` is
        not odd and positive.

    Examples
    --------
    >>> from rangeface.simulate import mean_head
    >>> scene = render(mean_head(), Orthographic(2.0, 25, 40, 50, 80))
    >>> bool(abs(scene.image.depth[40, 25]) < 0.01)
    True
    """
    if oversample < 1 or oversample % 2 == 0:
        raise ParameterError(f"oversample: must be odd and ≥ 1, got {oversample}")
    several = [surfaces] if isinstance(surfaces, Head | PointSet) else list(surfaces)
    motions: list[RigidTransform | None]
    motions = [poses] if isinstance(poses, RigidTransform) else list(poses or [None] * len(several))
    if len(motions) != len(several):
        raise ParameterError(f"poses: {len(motions)} for {len(several)} surfaces")
    points, triangles, looks = [], [], []
    first = 0
    for surface, motion in zip(several, motions, strict=True):
        mesh = surface.surface if isinstance(surface, Head) else surface
        if mesh.triangles is None:
            raise ParameterError("surfaces: a surface without triangles cannot be rendered")
        points.append(mesh.points if motion is None else motion.apply(mesh.points))
        triangles.append(mesh.triangles + first)
        looks.append(_look(surface))
        first += len(mesh.points)
    counts = [len(t) for t in triangles]
    return _view(
        np.concatenate(points), np.concatenate(triangles), np.concatenate(looks), counts,
        camera, oversample,
    )  # fmt: skip


def _view(
    points: NDArray[np.float64],
    triangles: NDArray[np.int32],
    look: Float32,
    counts: list[int],
    camera: Camera,
    oversample: int,
) -> Scene:
    fine = _refined(camera, oversample)
    perspective = isinstance(fine, Pinhole)
    focal = (fine.fx, fine.fy) if isinstance(fine, Pinhole) else (1 / fine.pitch_mm,) * 2
    depth, normal, triangle = zbuffer.rasterise(
        points, triangles, focal_px=focal, centre_px=(fine.cx, fine.cy),
        size_px=(fine.width, fine.height), perspective=perspective,
    )  # fmt: skip
    starts = np.concatenate([[0], np.cumsum(counts)])
    surface = np.repeat(np.arange(len(counts), dtype=np.int16), counts)
    seen = triangle >= 0
    hit = triangle[seen]
    reflectivity, shine = (np.zeros(triangle.shape, np.float32) for _ in range(2))
    corners = look[triangles.T]  # added by hand: a sum over an axis of three is five times slower
    mean_look = (corners[0] + corners[1] + corners[2]) / np.float32(3.0)
    reflectivity[seen], shine[seen] = mean_look[hit].T
    part, own = np.full(triangle.shape, -1, np.int16), np.full(triangle.shape, -1, np.int32)
    part[seen] = surface[hit]
    own[seen] = hit - starts[surface[hit]]
    return Scene(camera, depth, normal, reflectivity, shine, part, own, oversample)


def _look(surface: Head | PointSet) -> Float32:
    # reflectivity and shine of every vertex
    if isinstance(surface, Head):
        return np.stack([surface.reflectivity, SHINE[surface.tissue]], axis=-1)
    return np.tile(np.array([_GREY, 0.0], np.float32), (len(surface.points), 1))


def _refined(camera: Camera, k: int) -> Camera:
    if k == 1:
        return camera
    cx, cy = (k * c + 0.5 * (k - 1) for c in (camera.cx, camera.cy))
    if isinstance(camera, Pinhole):
        return Pinhole(k * camera.fx, k * camera.fy, cx, cy, k * camera.width, k * camera.height)
    return Orthographic(camera.pitch_mm / k, cx, cy, k * camera.width, k * camera.height)
