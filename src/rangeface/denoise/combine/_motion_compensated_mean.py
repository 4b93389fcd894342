from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain

import cv2
import numpy as np

from rangeface.denoise import _check
from rangeface.denoise.combine._frames import alike, divide, measured
from rangeface.errors import ParameterError
from rangeface.types import Float32, Float64, Mask, RangeImage, RigidTransform

_FIXED_POINT_STEPS = 3


def motion_compensated_mean(
    frames: Iterable[RangeImage],
    *,
    poses: Sequence[RigidTransform] | None = None,
    max_step_mm: float = 15.0,
) -> RangeImage:
    r"""Mean of frames of a moving head, each brought back to the first by its pose.

    .. math:: \bar z(p) = \frac{1}{n} \sum_k z\bigl[T_{1k}\, s_k\bigr](p), \qquad
              T_{1k} = T_{face,1}^{-1}\, T_{face,k}

    with s_k the surface of frame k, read where the ray of p meets it.

    Parameters
    ----------
    frames : iterable of RangeImage
        At least one, all of one camera; read once, one held beside the first.
    poses : sequence of RigidTransform
        T_face_camera of every frame.
    max_step_mm : float
        What lies farther from the first frame's depth (beyond 3√2 σ) is another surface.

    Returns
    -------
    RangeImage
        In the view of the first frame, whose holes stay holes. σ where every frame has it.

    Raises
    ------
    ParameterError
        There is no frame, the cameras differ, a pose is missing, or the step is not positive.

    Notes
    -----
    A frame is read bilinearly, which smooths by a fraction of a pixel; frames that did not move
    are read exactly. σ counts the frames, and neglects that smoothing.

    Examples
    --------
    >>> from rangeface.types import Orthographic
    >>> camera = Orthographic(2.0, 1, 1, 3, 3)
    >>> near, far = (RangeImage(np.full((3, 3), z), camera) for z in (400.0, 410.0))
    >>> still = RigidTransform(np.eye(3), np.zeros(3))
    >>> nearer = RigidTransform(np.eye(3), [0.0, 0.0, -10.0])
    >>> float(motion_compensated_mean([near, far], poses=[still, nearer]).depth[1, 1])
    400.0
    """
    _check.positive("max_step_mm", max_step_mm)
    stream = alike(frames)
    first = next(stream)
    pose = iter(poses or ())
    home = _next(pose, 0)
    count = depth = variance = np.zeros(())
    has_sigma = True
    for number, frame in enumerate(chain([first], stream)):
        motion = home if number == 0 else _next(pose, number)
        z, noise = _seen_from(first, frame, home.inverse() @ _renamed(motion, home), max_step_mm)
        good = np.isfinite(z) & measured(first)
        has_sigma &= frame.sigma is not None
        count = count + good
        depth = depth + np.where(good, z, 0.0)
        variance = variance + np.where(good, np.nan_to_num(noise) ** 2, 0.0)
    return first.with_depth(
        divide(depth, count),
        sigma=divide(np.sqrt(variance), count) if has_sigma else None,
        filled=None,
    )


def _next(poses: Iterable[RigidTransform], number: int) -> RigidTransform:
    for pose in poses:
        return pose
    raise ParameterError(f"poses: there is none for frame {number}; give one a frame")


def _renamed(pose: RigidTransform, like: RigidTransform) -> RigidTransform:
    """The pose with the frame names of another: all frames see the same face."""
    return RigidTransform(pose.rotation, pose.translation, like.target, like.source)


def _seen_from(
    first: RangeImage, frame: RangeImage, T_first_frame: RigidTransform, max_step_mm: float
) -> tuple[Float64, Float32]:
    """Depth and σ of a frame's surface along the rays of the first frame."""
    still = np.allclose(T_first_frame.rotation, np.eye(3)) and np.allclose(
        T_first_frame.translation, 0.0
    )
    valid = measured(frame)
    sigma = np.zeros(frame.shape, np.float32) if frame.sigma is None else frame.sigma
    if still:
        z = np.where(valid, frame.depth, np.nan).astype(np.float64)
        return _near(z, first, sigma, max_step_mm), sigma
    depth = np.where(valid, frame.depth, np.float32(np.nan))
    back = T_first_frame.inverse()
    z = first.depth.astype(np.float64)
    for _ in range(_FIXED_POINT_STEPS):
        # a guess of the depth on the ray → where frame k sees that place → the depth it saw
        pixel = frame.camera.project(back.apply(first.camera.back_project(z))).astype(np.float32)
        read = _bilinear(depth, pixel)
        there = _points_at(frame, pixel, read)
        z = np.where(np.isfinite(read), T_first_frame.apply(there)[..., 2], z)
    z = np.where(np.isfinite(read), z, np.nan)
    noise = cv2.remap(sigma, pixel, None, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
    return _near(z, first, noise, max_step_mm), noise


def _bilinear(depth: Float32, pixel: Float32) -> Float32:
    """Depth between pixels; NaN as soon as one of the four is, and outside the image."""
    where = np.nan_to_num(pixel, nan=-9.0)
    return cv2.remap(
        depth, where, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=np.nan
    )


def _points_at(frame: RangeImage, pixel: Float32, depth: Float32) -> Float64:
    """Points of a frame's camera at fractional pixels."""
    p = frame.camera.projection
    z = depth.astype(np.float64)
    scale = z if p.perspective else np.ones_like(z)
    x = (pixel[..., 0] - p.cx) / p.sx * scale
    y = (pixel[..., 1] - p.cy) / p.sy * scale
    return np.stack([x, y, z], axis=-1)


def _near(z: Float64, first: RangeImage, noise: Float32, max_step_mm: float) -> Float64:
    step = max_step_mm + 3.0 * np.sqrt(2.0) * np.nan_to_num(noise)
    close: Mask = np.abs(z - first.depth) <= step
    return np.where(close, z, np.nan)
