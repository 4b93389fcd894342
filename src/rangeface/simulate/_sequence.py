"""People who move and turn before a camera, frame by frame, with the truth about each pose."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rangeface.errors import ParameterError
from rangeface.sensors import SensorModel
from rangeface.simulate._capture import capture
from rangeface.simulate._head import Head
from rangeface.simulate._scene import Scene, pose, render
from rangeface.simulate._shapes import wall
from rangeface.simulate._tof import tof
from rangeface.types import PointSet, RangeImage, RigidTransform


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame of a sequence.

    Parameters
    ----------
    time_s : float
        Time since the first frame, s.
    image : RangeImage
        What the camera captured.
    poses : tuple of RigidTransform
        True T_camera_face of every person.
    scene : Scene
        The noise-free view; `scene.part` tells the people apart.
    """

    time_s: float
    image: RangeImage
    poses: tuple[RigidTransform, ...]
    scene: Scene


@dataclass(frozen=True)
class Motion:
    """How a person moves: each coordinate is a slow sum of two sines.

    Parameters
    ----------
    place_mm : tuple of float
        Mean position of the nose tip, camera frame, mm.
    sway_mm : float
        Amplitude of the movement, mm, ≥ 0.
    yaw_deg, pitch_deg, roll_deg : float
        Amplitudes of the turning, degrees, ≥ 0.
    period_s : float
        Period of the slower sine, s, > 0.
    seed : int
        Phases.

    Raises
    ------
    ParameterError
        An amplitude is negative, or the period is not positive.
    """

    place_mm: tuple[float, float, float] = (0.0, 0.0, 400.0)
    sway_mm: float = 10.0
    yaw_deg: float = 12.0
    pitch_deg: float = 6.0
    roll_deg: float = 3.0
    period_s: float = 3.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("sway_mm", "yaw_deg", "pitch_deg", "roll_deg"):
            if not getattr(self, name) >= 0:
                raise ParameterError(f"{name}: must be ≥ 0, got {getattr(self, name)}")
        if not self.period_s > 0:
            raise ParameterError(f"period_s: must be > 0, got {self.period_s}")

    def at(self, time_s: float) -> RigidTransform:
        """Pose T_camera_face at a time, s."""
        rng = np.random.default_rng([self.seed, 0x307E])
        phase = 2.0 * np.pi * rng.random((2, 6))
        rate = 2.0 * np.pi / self.period_s * rng.uniform(0.8, 1.25, 6)
        wave = 0.7 * np.sin(rate * time_s + phase[0]) + 0.3 * np.sin(2.3 * rate * time_s + phase[1])
        x, y, z = np.array(self.place_mm) + self.sway_mm * wave[3:]
        return pose(
            yaw_deg=self.yaw_deg * wave[0],
            pitch_deg=self.pitch_deg * wave[1],
            roll_deg=self.roll_deg * wave[2],
            nose_tip_mm=(x, y, z),
        )


def sequence(
    people: Sequence[Head],
    sensor: SensorModel,
    *,
    motions: Sequence[Motion] | None = None,
    frames: int = 20,
    rate_hz: float = 20.0,
    wall_mm: float | None = 1500.0,
    bucket_s: float = 0.0,
    oversample: int = 3,
    rng: np.random.Generator,
) -> Iterator[Frame]:
    """Frames of one or several moving people, drawn one by one.

    Parameters
    ----------
    people : sequence of Head
        Who is seen, at least one.
    sensor : SensorModel
        With its camera.
    motions : sequence of Motion, optional
        How each moves. Default: side by side, 400 mm away, 260 mm apart.
    frames : int
        Number of frames, ≥ 1.
    rate_hz : float
        Frames per second, > 0.
    wall_mm : float, optional
        Depth of a wall behind them, mm; None: nothing is behind them.
    bucket_s : float
        Time between two buckets, s, ≥ 0; above 0 a "phase" sensor sees people move between them.
    oversample : int
        As in `render`.
    rng : numpy.random.Generator
        Source of the noise.

    Yields
    ------
    Frame
        Image and truth.

    Raises
    ------
    ParameterError
        Nobody, as many motions as people are not given, or a number out of range.

    Examples
    --------
    >>> from rangeface import sensors, simulate
    >>> sensor = sensors.preset("sr3000")
    >>> two = simulate.sequence([simulate.head(0), simulate.head(1)], sensor, frames=2,
    ...                         oversample=1, rng=np.random.default_rng(0))
    >>> [len(frame.poses) for frame in two]
    [2, 2]
    """
    if not people:
        raise ParameterError("people: at least one is needed")
    if frames < 1:
        raise ParameterError(f"frames: must be ≥ 1, got {frames}")
    if not rate_hz > 0:
        raise ParameterError(f"rate_hz: must be > 0, got {rate_hz}")
    if not bucket_s >= 0:
        raise ParameterError(f"bucket_s: must be ≥ 0, got {bucket_s}")
    paths = _side_by_side(len(people)) if motions is None else list(motions)
    if len(paths) != len(people):
        raise ParameterError(f"motions: {len(paths)} for {len(people)} people")
    surfaces: list[Head | PointSet] = [*people]
    if wall_mm is not None:
        surfaces.append(wall(wall_mm))

    def look(time_s: float) -> tuple[Scene, tuple[RigidTransform, ...]]:
        poses = tuple(path.at(time_s) for path in paths)
        still: list[RigidTransform | None] = [None] * (len(surfaces) - len(poses))
        return render(surfaces, sensor.camera, [*poses, *still], oversample=oversample), poses

    return _frames(look, sensor, frames, rate_hz, bucket_s, rng)


def _frames(
    look: Callable[[float], tuple[Scene, tuple[RigidTransform, ...]]],
    sensor: SensorModel,
    frames: int,
    rate_hz: float,
    bucket_s: float,
    rng: np.random.Generator,
) -> Iterator[Frame]:
    for number in range(frames):
        time_s = number / rate_hz
        scene, poses = look(time_s)
        if bucket_s and sensor.principle == "phase":
            buckets = range(len(sensor.frequencies_hz) * sensor.phases)
            image = tof([look(time_s + k * bucket_s)[0] for k in buckets], sensor, rng=rng)
        else:
            image = capture(scene, sensor, rng=rng)
        yield Frame(time_s, image, poses, scene)


def _side_by_side(people: int) -> list[Motion]:
    return [
        Motion(
            place_mm=(260.0 * (i - 0.5 * (people - 1)), 0.0, 400.0 + 300.0 * (people > 1)), seed=i
        )
        for i in range(people)
    ]
