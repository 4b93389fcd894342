"""A scene as a sensor captures it: one function for every principle of measurement."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

import numpy as np

from rangeface.errors import ParameterError
from rangeface.numerics import draws
from rangeface.sensors import SensorModel
from rangeface.simulate import _tof
from rangeface.simulate._scene import Scene
from rangeface.simulate._tof import amplitude, tof
from rangeface.types import RangeImage


def capture(scene: Scene, sensor: SensorModel, *, rng: np.random.Generator) -> RangeImage:
    """Capture of a scene by any sensor.

    Parameters
    ----------
    scene : Scene
        The view, rendered with the sensor's camera or any other.
    sensor : SensorModel
        Its principle decides how noise arises: `tof`, `random_point` or `triangulate`.
    rng : numpy.random.Generator
        Source of the noise.

    Returns
    -------
    RangeImage
        Depth and σ, mm; amplitude where the principle has one.

    Examples
    --------
    >>> from rangeface import sensors, simulate
    >>> sensor = sensors.preset("laser-scanner")
    >>> view = simulate.render(simulate.mean_head(), sensor.camera,
    ...                        simulate.pose(nose_tip_mm=(0.0, 0.0, 900.0)))
    >>> image = capture(view, sensor, rng=np.random.default_rng(0))
    >>> round(float(np.nanstd(image.depth - view.image.depth)), 2)
    0.2
    """
    return METHODS[sensor.principle](scene, sensor, rng=rng)


def frames(
    scene: Scene, sensor: SensorModel, count: int, *, rng: np.random.Generator
) -> Iterator[RangeImage]:
    """Several captures of a still scene: the light is computed once, the noise for each frame.

    Parameters
    ----------
    scene : Scene
        The view.
    sensor : SensorModel
        Any sensor.
    count : int
        Number of frames, ≥ 1.
    rng : numpy.random.Generator
        Source of the noise.

    Yields
    ------
    RangeImage
        As `capture` would give, one after the other.

    Raises
    ------
    ParameterError
        The number of frames is below 1.

    Examples
    --------
    >>> from rangeface import sensors, simulate
    >>> sensor = sensors.preset("sr3000")
    >>> view = simulate.render(simulate.mean_head(), sensor.camera, simulate.pose())
    >>> first, second = frames(view, sensor, 2, rng=np.random.default_rng(0))
    >>> bool((first.depth != second.depth).any())
    True
    """
    if count < 1:
        raise ParameterError(f"count: must be ≥ 1, got {count}")
    if sensor.principle != "phase":
        return (capture(scene, sensor, rng=rng) for _ in range(count))
    lights, camera = _tof.exposure(scene, sensor)
    return (
        _tof.decode(_tof.Buckets(_tof.count(lights, sensor, rng=rng), camera), sensor)
        for _ in range(count)
    )


def random_point(scene: Scene, sensor: SensorModel, *, rng: np.random.Generator) -> RangeImage:
    r"""The source paper's model: the angle of a normally distributed point in the plane.

    .. math:: \hat φ = \arg(A e^{iφ} + n_1 + i n_2), \quad n_1, n_2 \sim N(0, 1), \quad
              σ_φ \approx 1/A

    Parameters
    ----------
    scene : Scene
        The view.
    sensor : SensorModel
        Signal, lobe and first modulation frequency are used; principle "paper".
    rng : numpy.random.Generator
        Source of the noise.

    Returns
    -------
    RangeImage
        Depth (mm), amplitude in units of the noise, σ = L / (2πA) (mm).

    Raises
    ------
    ParameterError
        The sensor's principle is not "paper".

    Notes
    -----
    The law σ = 1/A holds for A ≫ 1 only; at small A the angle wraps, as in the paper's model.
    """
    if sensor.principle != "paper":
        raise ParameterError(f"sensor: {sensor.name!r} is not of the principle 'paper'")
    clean = scene.image
    middle = slice(scene.oversample // 2, None, scene.oversample)
    A = amplitude(scene, sensor)[middle, middle]
    angle, length = draws.angle_noise(A, rng=rng)
    ray = clean.camera.radial_factor()
    L = float(sensor.ambiguities_mm()[0])
    radial = np.mod(clean.depth * ray + L / (2.0 * np.pi) * angle, L)
    seen = clean.mask & (length > sensor.min_snr)
    return RangeImage(
        np.where(seen, radial / ray, np.nan), clean.camera,
        sigma=np.where(seen, sensor.range_sigma(length, 0.0) / ray, np.nan), amplitude=length,
    )  # fmt: skip


def triangulate(scene: Scene, sensor: SensorModel, *, rng: np.random.Generator) -> RangeImage:
    """A triangulating sensor: Gaussian noise that grows with the square of the depth.

    Parameters
    ----------
    scene : Scene
        The view.
    sensor : SensorModel
        `floor_mm`, `quadratic_per_mm` and `step_per_mm` are used; principle "triangulation".
    rng : numpy.random.Generator
        Source of the noise.

    Returns
    -------
    RangeImage
        Depth and σ, mm.

    Raises
    ------
    ParameterError
        The sensor's principle is not "triangulation".
    """
    if sensor.principle != "triangulation":
        raise ParameterError(f"sensor: {sensor.name!r} is not of the principle 'triangulation'")
    clean = scene.image
    sigma = sensor.depth_sigma(clean.depth).astype(np.float32)
    depth = clean.depth + sigma * draws.normal(clean.shape, rng=rng)
    if sensor.step_per_mm:
        # equal steps of disparity 1/z are steps of step_per_mm · z² in depth
        depth = 1.0 / (np.round(1.0 / (depth * sensor.step_per_mm)) * sensor.step_per_mm)
    return RangeImage(depth, clean.camera, sigma=sigma)


METHODS: Mapping[str, Callable[..., RangeImage]] = MappingProxyType(
    {"phase": tof, "paper": random_point, "triangulation": triangulate}
)
