"""A camera that does not exist, before which people who do not exist come and go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import count

import numpy as np

from rangeface import sensors, simulate
from rangeface.errors import ParameterError
from rangeface.sensors import SensorModel
from rangeface.simulate import Head, Scene
from rangeface.sources._protocol import Closing, Frame, Seen
from rangeface.sources._script import Walk, comings_and_goings, distance_mm
from rangeface.types import PointSet, RangeImage, RigidTransform

#: Rendered views are kept, up to this much of them, and only their noise is drawn again.
_CACHE_BYTES = 300e6
_BEHIND_MM = 700.0


class SyntheticCamera(Closing):
    """Frames of a simulated sensor, with the truth about who is seen.

    Parameters
    ----------
    sensor : str or SensorModel
        Preset of `rangeface.sensors`, or a sensor.
    walks : sequence of Walk, optional
        Who comes and goes; default: `comings_and_goings` of six people.
    rate_hz : float
        Frames a second, > 0.
    repeat : bool
        Begin again when the last has gone; else the source ends.
    keep : bool
        Keep rendered views for the next round (at most 300 MB of them).
    seed : int
        Of the noise.

    Raises
    ------
    ParameterError
        An unknown sensor, nobody, or a rate that is not > 0.

    Notes
    -----
    A view is rendered once (about 15 ms at 176 × 144 pixels) and kept; later rounds only draw
    its noise again (about 5 ms). Frames come as fast as they are asked for: `Player` paces them.

    Examples
    --------
    >>> camera = SyntheticCamera("sr3000", repeat=False)
    >>> frame = next(iter(camera))
    >>> frame.number, frame.time_s, [seen.person for seen in frame.truth]
    (0, 0.0, [0])
    """

    def __init__(
        self,
        sensor: str | SensorModel = "sr3000",
        walks: Sequence[Walk] | None = None,
        *,
        rate_hz: float = 30.0,
        repeat: bool = True,
        keep: bool = True,
        seed: int = 0,
    ) -> None:
        if not rate_hz > 0:
            raise ParameterError(f"rate_hz: must be > 0, got {rate_hz}")
        model = sensors.preset(sensor) if isinstance(sensor, str) else sensor
        self._walks = tuple(comings_and_goings(model) if walks is None else walks)
        if not self._walks:
            raise ParameterError("walks: nobody comes")
        self._sensor = model
        self._rate_hz = rate_hz
        self._repeat = repeat
        self._kept_bytes = _CACHE_BYTES if keep else 0.0
        self._rng = np.random.default_rng(seed)
        self._frames = round(max(w.stop_s for w in self._walks) * rate_hz)
        self._wall = simulate.wall(
            max(w.place_mm[2] for w in self._walks) + _BEHIND_MM, half_mm=6000.0
        )
        self._noisy: dict[int, Iterator[RangeImage]] = {}
        self._closed = False

    @property
    def name(self) -> str:
        """Its address."""
        return f"synthetic:{self._sensor.name}"

    @property
    def rate_hz(self) -> float:
        """Frames a second."""
        return self._rate_hz

    @property
    def walks(self) -> tuple[Walk, ...]:
        """Who comes and goes, in one round."""
        return self._walks

    def close(self) -> None:
        """End after the frame that is being made."""
        self._closed = True

    def __iter__(self) -> Iterator[Frame]:
        for number in count() if self._repeat else range(self._frames):
            if self._closed:
                return
            moment = number % self._frames
            present = [
                (walk, motion)
                for walk in self._walks
                if (motion := walk.at(moment / self._rate_hz)) is not None
            ]
            yield Frame(
                self._image(moment, present), number / self._rate_hz, number,
                truth=tuple(Seen(walk.person, motion) for walk, motion in present),
            )  # fmt: skip

    def _image(self, moment: int, present: list[tuple[Walk, RigidTransform]]) -> RangeImage:
        kept = self._noisy.get(moment)
        if kept is None:
            scene = self._render(present)
            kept = simulate.frames(scene, self._sensor, 1_000_000_000, rng=self._rng)
            if len(self._noisy) * _bytes(scene, self._sensor) < self._kept_bytes:
                self._noisy[moment] = kept
        return next(kept)

    def _render(self, present: list[tuple[Walk, RigidTransform]]) -> Scene:
        surfaces: list[Head | PointSet] = [_head(w.person, w.expression, w.session)
                                           for w, _ in present]  # fmt: skip
        motions = [motion for _, motion in present]
        scene = simulate.render([*surfaces, self._wall], self._sensor.camera, [*motions, None])
        if self._sensor.principle == "phase":
            return scene
        nothing = np.zeros((), np.float32)  # a triangulating sensor does not ask for the light
        plane = np.broadcast_to(nothing, scene.depth.shape)
        normal = np.broadcast_to(nothing, scene.normal.shape)
        return replace(scene, normal=normal, reflectivity=plane, shine=plane)


def _bytes(scene: Scene, sensor: SensorModel) -> float:
    """What a kept view takes: a float32 for every bucket, or the depth and two labels."""
    planes = len(sensor.frequencies_hz) * sensor.phases if sensor.principle == "phase" else 3
    return 4.0 * planes * scene.depth.size


@lru_cache(maxsize=64)
def _head(person: int, expression: str, session: int) -> Head:
    return simulate.head(person, expression=expression, session=session)


def enrolment(
    sensor: str | SensorModel, person: int, *, frames: int = 10, seed: int = 0
) -> list[RangeImage]:
    """Frames of a person who stands still before a synthetic camera, on the day of enrolment.

    Parameters
    ----------
    sensor : str or SensorModel
        As in `SyntheticCamera`.
    person : int
        Number of the head.
    frames : int
        Number of frames, ≥ 1.
    seed : int
        Of the noise.

    Returns
    -------
    list of RangeImage
        To be combined into one template.

    Raises
    ------
    ParameterError
        An unknown sensor, or no frame.
    """
    model = sensors.preset(sensor) if isinstance(sensor, str) else sensor
    where = simulate.pose(nose_tip_mm=(0.0, 0.0, distance_mm(model)))
    scene = simulate.render(_head(person, "neutral", 0), model.camera, where)
    return list(simulate.frames(scene, model, frames, rng=np.random.default_rng([seed, person])))
