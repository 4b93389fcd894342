"""A continuous-wave time-of-flight camera, simulated where its errors arise: in the buckets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError
from rangeface.numerics import draws, phasor
from rangeface.sensors import SPEED_OF_LIGHT_MM_S, SensorModel
from rangeface.simulate._scene import Scene
from rangeface.types import Camera, Float32, RangeImage

Complex64: TypeAlias = NDArray[np.complex64]

_SHINE_POWER = 100.0  # the lamp's image on a wet eye is some ten degrees wide
_HOLLOW_MM = 20.0  # depth of a hollow that receives the whole second bounce
_NEAR_PX = 6.0  # how far a second bounce reaches


@dataclass(frozen=True, eq=False)
class Buckets:
    """What the pixels counted.

    Parameters
    ----------
    counts : (f, N, H, W) float32
        Counts per frequency and phase step.
    camera : Pinhole or Orthographic
        Camera of the image.
    """

    counts: Float32
    camera: Camera


def tof(
    scene: Scene | Sequence[Scene], sensor: SensorModel, *, rng: np.random.Generator
) -> RangeImage:
    r"""Capture of a scene by a phase-shift time-of-flight camera.

    .. math:: I_k = B + A \cos(φ + 2πk/N), \quad φ = 2πd/L, \quad L = c/2f

    with Poisson counts; then φ̂ = arg Σ I_k exp(−2πik/N), as the camera itself computes it.

    Parameters
    ----------
    scene : Scene, or sequence of one Scene a bucket
        The view; a sequence simulates motion between the buckets.
    sensor : SensorModel
        With principle "phase".
    rng : numpy.random.Generator
        Source of the noise.

    Returns
    -------
    RangeImage
        Depth z (mm), amplitude (counts), sigma (mm, from the measured buckets); NaN where the
        signal is too weak, saturated, or the pixel is dead.

    Raises
    ------
    ParameterError
        The sensor's principle is not "phase", or the number of scenes fits no bucket count.

    References
    ----------
    R. Lange, P. Seitz, IEEE J. Quantum Electron. 37(3), 2001, doi:10.1109/3.910448.

    Examples
    --------
    >>> from rangeface import sensors, simulate
    >>> sensor = sensors.preset("sr3000").ideal()
    >>> scene = simulate.render(simulate.mean_head(), sensor.camera, simulate.pose())
    >>> image = tof(scene, sensor, rng=np.random.default_rng(0))
    >>> error = image.depth - scene.image.depth
    >>> bool(np.nanmax(np.abs(error)) < 0.01)
    True
    """
    return decode(buckets(scene, sensor, rng=rng), sensor)


def buckets(
    scene: Scene | Sequence[Scene], sensor: SensorModel, *, rng: np.random.Generator
) -> Buckets:
    """What the buckets of a time-of-flight camera count; parameters as in `tof`.

    Returns
    -------
    Buckets
        Counts before decoding.

    Raises
    ------
    ParameterError
        As in `tof`.
    """
    lights, camera = exposure(scene, sensor)
    return Buckets(count(lights, sensor, rng=rng), camera)


Light: TypeAlias = tuple[Complex64, Float32]


def exposure(
    scene: Scene | Sequence[Scene], sensor: SensorModel
) -> tuple[tuple[Light, ...], Camera]:
    """Light on the pixels for every bucket: signal and mean count; parameters as in `tof`."""
    if sensor.principle != "phase":
        raise ParameterError(f"sensor: {sensor.name!r} has no buckets ({sensor.principle})")
    scenes = [scene] if isinstance(scene, Scene) else list(scene)
    steps = [f for f in sensor.frequencies_hz for _ in range(sensor.phases)]
    if len(scenes) not in (1, len(steps)):
        raise ParameterError(f"scene: 1 or {len(steps)} scenes (one a bucket), got {len(scenes)}")
    if len(scenes) > 1:
        moving = zip(scenes, steps, strict=True)
        return tuple(_light(view, sensor, f) for view, f in moving), scenes[0].camera
    still = {f: _light(scenes[0], sensor, f) for f in sensor.frequencies_hz}
    return tuple(still[f] for f in steps), scenes[0].camera


def count(lights: Sequence[Light], sensor: SensorModel, *, rng: np.random.Generator) -> Float32:
    """What the buckets count in one frame, (f, N, H, W)."""
    shape = (len(sensor.frequencies_hz), sensor.phases, *lights[0][0].shape)
    jitter = sensor.jitter_rad * rng.standard_normal(shape[0])
    gains = 1.0 + sensor.modulation_error * rng.standard_normal(shape[:2])
    counts = np.empty(shape, np.float32)
    for index, (signal, mean) in enumerate(lights):
        f, k = divmod(index, sensor.phases)
        shift = 2.0 * np.pi * k / sensor.phases + jitter[f]
        counts[f, k] = mean + np.float32(gains[f, k]) * _correlation(signal, shift, sensor)
    return _detect(counts, sensor, rng)


def decode(captured: Buckets, sensor: SensorModel) -> RangeImage:
    """Depth, amplitude and σ from bucket counts, as the camera computes them.

    Parameters
    ----------
    captured : Buckets
        Counts.
    sensor : SensorModel
        The sensor that captured them.

    Returns
    -------
    RangeImage
        As from `tof`.
    """
    counts, camera = captured.counts, captured.camera
    signal = phasor.decode(counts)
    amplitude, mean = np.abs(signal).mean(axis=0), counts.mean(axis=(0, 1))
    radial = phasor.unwrap(np.angle(signal), sensor.ambiguities_mm(), sensor.ambiguity_mm)
    sigma = sensor.range_sigma(amplitude, mean)
    weakest = np.maximum(sensor.min_snr * sensor.amplitude_sigma(mean), sensor.min_amplitude)
    bad = (amplitude <= weakest) | (counts.max(axis=(0, 1)) >= sensor.full_well)
    bad |= _specimen(sensor, camera.height, camera.width)[2]
    depth = np.where(bad, np.nan, radial / camera.radial_factor())
    return RangeImage(
        depth.astype(np.float32), camera,
        sigma=np.where(bad, np.nan, sigma / camera.radial_factor()), amplitude=amplitude,
    )  # fmt: skip


def amplitude(scene: Scene, sensor: SensorModel) -> Float32:
    r"""Amplitude that each sample of a scene returns to the sensor.

    .. math:: A = S \, ρ \, |n_z| \, \left(\frac{1\,\mathrm m}{r}\right)^2 \cos^m α

    with the signal S of a white surface at 1 m, reflectivity ρ, the normal's component n_z on the
    optical axis, radial range r and the emitter's lobe in the angle α from the axis; eyes and
    lenses add a mirror-like part.

    Parameters
    ----------
    scene : Scene
        The view.
    sensor : SensorModel
        Signal and lobe.

    Returns
    -------
    (kH, kW) float32
        Counts; 0 where nothing is seen.
    """
    ray, lobe = _optics(scene.fine_camera, sensor.lobe_power)
    facing = np.abs(scene.normal[..., 2])
    returned = scene.reflectivity * facing
    wet = scene.shine > 0
    returned[wet] += scene.shine[wet] * facing[wet] ** _SHINE_POWER
    law = returned * lobe / (scene.depth * ray * np.float32(1e-3)) ** 2
    return np.nan_to_num(np.float32(sensor.signal) * law)


def _light(scene: Scene, sensor: SensorModel, frequency_hz: float) -> Light:
    """Complex signal and mean count per pixel, before the electronics."""
    A = amplitude(scene, sensor)
    ray, _ = _optics(scene.fine_camera, 0.0)
    seen = A > 0
    signal = np.zeros(A.shape, np.complex64)
    signal[seen] = A[seen] * _turned(scene.depth[seen] * ray[seen], frequency_hz)
    # light inside a pixel adds as phasors: at an edge the mixture lies between the surfaces
    signal, own = _binned(signal, scene.oversample), _binned(A, scene.oversample) / sensor.contrast
    ambient = sensor.background * _binned(scene.reflectivity, scene.oversample)
    signal = signal + sensor.multipath * signal.mean()
    if sensor.bounce:
        signal = signal + sensor.bounce * _second_bounce(scene, signal, frequency_hz)
    if sensor.scattering:
        spread = sensor.scattering_px
        signal = signal + sensor.scattering * (_blurred(signal, spread) - signal)
        own = own + sensor.scattering * (_blurred(own, spread) - own)
    _, lens = _optics(scene.camera, sensor.vignetting)
    offset_mm, gain, _ = _specimen(sensor, *signal.shape)
    signal = lens * gain * signal * _turned(offset_mm, frequency_hz)
    mean = lens * gain * (own + ambient) + np.float32(sensor.dark)
    return signal.astype(np.complex64, copy=False), mean.astype(np.float32, copy=False)


def _turned(radial_mm: Float32, frequency_hz: float) -> Complex64:
    """Unit phasors of a radial range."""
    turns = np.asarray(radial_mm, np.float64) * (2.0 * frequency_hz / SPEED_OF_LIGHT_MM_S)
    angle = (2.0 * np.pi * (turns - np.round(turns))).astype(np.float32)
    out = np.empty(angle.shape, np.complex64)
    out.real, out.imag = np.cos(angle), np.sin(angle)
    return out


@lru_cache(maxsize=16)
def _optics(camera: Camera, power: float) -> tuple[Float32, Float32]:
    """Radial factor of each pixel, and cos^power of its angle from the axis."""
    ray = camera.radial_factor()
    return ray, ray ** np.float32(-power)


def _blurred(plane: NDArray[Any], spread_px: float) -> NDArray[Any]:
    if np.iscomplexobj(plane):
        channels = np.ascontiguousarray(plane).view(np.float32).reshape(*plane.shape, 2)
        blurred = _blurred(channels, spread_px)
        return np.ascontiguousarray(blurred).view(np.complex64)[..., 0]
    return cv2.GaussianBlur(plane, (0, 0), spread_px, borderType=cv2.BORDER_CONSTANT)


def _binned(plane: NDArray[Any], k: int) -> NDArray[Any]:
    parts = [plane[i::k, j::k] for i in range(k) for j in range(k)]
    return np.asarray(sum(parts[1:], parts[0]) / np.float32(k * k))


def _second_bounce(scene: Scene, signal: Complex64, frequency_hz: float) -> Complex64:
    # a pixel deeper than its surroundings sees them, and their light has gone further
    depth = np.nan_to_num(scene.image.depth)
    seen = (depth > 0).astype(np.float32)
    share = np.maximum(_blurred(seen, _NEAR_PX), np.float32(1e-6))
    around = _blurred(depth, _NEAR_PX) / share
    hollow = np.clip((depth - around) / np.float32(_HOLLOW_MM), 0.0, 1.0) * seen
    further = _turned(np.array(_HOLLOW_MM), frequency_hz)
    return hollow * further * _blurred(signal, _NEAR_PX) / share


def _correlation(signal: Complex64, shift: float, sensor: SensorModel) -> Float32:
    strength = np.abs(signal)
    turned = (signal * np.complex64(np.exp(1j * shift))).real
    third, fifth = np.float32(sensor.third_harmonic), np.float32(sensor.fifth_harmonic)
    if not (third or fifth):
        return turned
    # cos 3x and cos 5x by Chebyshev's polynomials of c = cos x
    c = turned / np.maximum(strength, np.float32(1e-20))
    c2 = c * c
    wave = c * (1.0 + third * (4.0 * c2 - 3.0) + fifth * ((16.0 * c2 - 20.0) * c2 + 5.0))
    return np.asarray(strength * wave)


def _detect(counts: Float32, sensor: SensorModel, rng: np.random.Generator) -> Float32:
    """Photons to numbers: shot noise, compression, saturation, read noise, converter."""
    counts = np.maximum(counts, 0.0)
    if sensor.shot_noise:
        noisy = draws.poisson(counts, rng=rng)
        counts = counts + np.sqrt(sensor.shot_noise) * (noisy - counts)
    if sensor.compression:
        counts = counts * (1.0 - sensor.compression * np.minimum(counts / sensor.full_well, 1.0))
    counts = np.minimum(counts, sensor.full_well)
    if sensor.read_noise:
        counts = counts + sensor.read_noise * draws.normal(counts.shape, rng=rng)
    if step := sensor.converter_step:
        counts = np.clip(np.round(counts / step) * step, 0.0, sensor.full_well)
    return np.asarray(counts, np.float32)


@lru_cache(maxsize=8)
def _specimen(
    sensor: SensorModel, height: int, width: int
) -> tuple[Float32, Float32, NDArray[np.bool_]]:
    """Offset (mm), gain and dead pixels of one specimen: always the same for its number."""
    rng = np.random.default_rng([sensor.device, height, width])
    offset = sensor.fixed_pattern_mm * rng.standard_normal((height, width), np.float32)
    gain = 1.0 + sensor.gain_pattern * rng.standard_normal((height, width), np.float32)
    return offset, np.maximum(gain, 0.0), rng.random((height, width)) < sensor.dead_pixels
