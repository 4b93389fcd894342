"""A range sensor as numbers: geometry, modulation, light, noise and systematic errors.

Counts are electrons before the converter. An effect whose number is 0 is off, and
`SensorModel.without` switches effects off by name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError
from rangeface.types import Pinhole

Float64: TypeAlias = NDArray[np.float64]

SPEED_OF_LIGHT_MM_S = 299_792_458_000.0

PRINCIPLES = ("phase", "paper", "triangulation")

# what each switch sets to "nothing happens"
EFFECTS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "background": {"background": 0.0},
        "dark current": {"dark": 0.0},
        "jitter": {"jitter_rad": 0.0},
        "modulation error": {"modulation_error": 0.0},
        "read noise": {"read_noise": 0.0},
        "converter": {"bits": 0},
        "saturation": {"full_well": np.inf},
        "compression": {"compression": 0.0},
        "wiggling": {"third_harmonic": 0.0, "fifth_harmonic": 0.0},
        "multipath": {"multipath": 0.0, "bounce": 0.0},
        "scattering": {"scattering": 0.0},
        "fixed pattern": {"fixed_pattern_mm": 0.0, "gain_pattern": 0.0},
        "vignetting": {"vignetting": 0.0},
        "dead pixels": {"dead_pixels": 0.0},
        "shot noise": {"shot_noise": 0.0},
        "threshold": {"min_snr": 0.0, "min_amplitude": 0.0},
    }
)


@dataclass(frozen=True)
class SensorModel:
    """A range sensor.

    Parameters
    ----------
    name : str
        Name of the preset or of the user's own sensor.
    source : str
        What is published about it, and where.
    camera : Pinhole
        Intrinsics.
    principle : {"phase", "paper", "triangulation"}
        "phase": continuous-wave time of flight, buckets with Poisson noise. "paper": the angle of
        a normally distributed point in the plane, σ_φ = 1/A. "triangulation": Gaussian depth
        noise of `floor_mm + quadratic_per_mm · z²`.
    frequencies_hz : tuple of float
        Modulation frequencies; two or more extend the unambiguous range.
    phases : int
        Buckets per frequency, ≥ 3.
    signal : float
        Amplitude of a white, frontal surface at 1 m in the middle of the lobe, counts per bucket.
    contrast : float
        Demodulation contrast, 0 < contrast ≤ 1: amplitude over mean of the sensor's own light.
    lobe_power : float
        The emitter sends cos(angle)^lobe_power.
    background, dark : float
        Ambient light on a white surface, and dark current, counts per bucket.
    shot_noise : float
        1 = Poisson, 0 = none.
    jitter_rad : float
        Standard deviation of the phase common to a frame, rad.
    modulation_error : float
        Relative standard deviation of each bucket's gain in a frame.
    read_noise : float
        Standard deviation per bucket, counts.
    full_well : float
        Counts at which a bucket saturates (inf: never).
    compression : float
        Response before saturation: c → c (1 − compression · c / full_well).
    bits : int
        Converter's resolution over the full well; 0 = no rounding.
    third_harmonic, fifth_harmonic : float
        Relative strength of the odd harmonics of the correlation: wiggling.
    multipath : float
        Part of the mean returned light that reaches every pixel as a global offset.
    bounce : float
        Part of its neighbours' light that a pixel in a hollow receives by a second bounce.
    scattering : float
        Part of the light that the lens spreads over `scattering_px` (internal scattering).
    scattering_px : float
        Standard deviation of that spread, px.
    fixed_pattern_mm, gain_pattern : float
        Standard deviations of each pixel's own offset and relative gain.
    vignetting : float
        Exponent p of the lens's fall-off cos(angle)^p; 4 is the natural law.
    dead_pixels : float
        Part of the pixels that never answer.
    device : int
        Seed of the fixed patterns: another number is another specimen.
    floor_mm, quadratic_per_mm : float
        Noise law of "triangulation".
    step_per_mm : float
        Depth resolution of "triangulation" over z²; 0 = no rounding.
    min_snr, min_amplitude : float
        Pixels whose amplitude is below `min_snr` · noise, or below `min_amplitude` counts, are
        invalid.

    Raises
    ------
    ParameterError
        A number is out of range; the message names it.

    Examples
    --------
    >>> from rangeface.sensors import preset
    >>> sensor = preset("sr3000")
    >>> round(sensor.ambiguity_mm)
    7495
    >>> sensor.without("multipath", "wiggling").multipath
    0.0
    """

    name: str
    source: str
    camera: Pinhole
    principle: str = "phase"
    frequencies_hz: tuple[float, ...] = (20e6,)
    phases: int = 4
    signal: float = 10_000.0
    contrast: float = 0.5
    lobe_power: float = 0.0
    background: float = 0.0
    dark: float = 0.0
    shot_noise: float = 1.0
    jitter_rad: float = 0.0
    modulation_error: float = 0.0
    read_noise: float = 0.0
    full_well: float = np.inf
    compression: float = 0.0
    bits: int = 0
    third_harmonic: float = 0.0
    fifth_harmonic: float = 0.0
    multipath: float = 0.0
    bounce: float = 0.0
    scattering: float = 0.0
    scattering_px: float = 20.0
    fixed_pattern_mm: float = 0.0
    gain_pattern: float = 0.0
    vignetting: float = 0.0
    dead_pixels: float = 0.0
    device: int = 0
    floor_mm: float = 0.0
    quadratic_per_mm: float = 0.0
    step_per_mm: float = 0.0
    min_snr: float = 4.0
    min_amplitude: float = 0.0

    def __post_init__(self) -> None:
        if self.principle not in PRINCIPLES:
            raise ParameterError(f"principle: one of {PRINCIPLES}, got {self.principle!r}")
        if not self.frequencies_hz or min(self.frequencies_hz) <= 0:
            raise ParameterError(f"frequencies_hz: must be > 0, got {self.frequencies_hz}")
        if self.phases < 3:
            raise ParameterError(f"phases: at least 3 buckets, got {self.phases}")
        for name in ("signal", "full_well", "scattering_px"):
            if not getattr(self, name) > 0:
                raise ParameterError(f"{name}: must be > 0, got {getattr(self, name)}")
        for name in (
            "contrast",
            "multipath",
            "bounce",
            "scattering",
            "dead_pixels",
            "compression",
            "shot_noise",
        ):
            if not 0 <= getattr(self, name) <= 1:
                raise ParameterError(f"{name}: must lie in 0 … 1, got {getattr(self, name)}")
        if self.contrast == 0:
            raise ParameterError("contrast: must be > 0")
        for name in _NOT_NEGATIVE:
            if not getattr(self, name) >= 0:
                raise ParameterError(f"{name}: must be ≥ 0, got {getattr(self, name)}")

    @property
    def ambiguity_mm(self) -> float:
        """Range after which the phases of all frequencies repeat, mm."""
        common = np.gcd.reduce(np.round(self.frequencies_hz).astype(np.int64))
        return float(SPEED_OF_LIGHT_MM_S / (2.0 * common))

    def ambiguities_mm(self) -> Float64:
        """Unambiguous range L = c / 2f of each frequency alone, mm."""
        return SPEED_OF_LIGHT_MM_S / (2.0 * np.asarray(self.frequencies_hz, np.float64))

    def range_sigma(self, amplitude: ArrayLike, mean: ArrayLike) -> Float64:
        r"""Standard deviation of the radial range at a high signal-to-noise ratio.

        .. math:: σ_d = \frac{L}{2π} \frac{\sqrt{2 (B + r^2) / N}}{A}, \qquad
                  N = 4: \; σ_d = \frac{L \sqrt{B}}{2 \sqrt{2} π A}

        For several frequencies the estimates are combined by inverse variance.

        Parameters
        ----------
        amplitude, mean : (...) array_like
            Amplitude A and mean B of the buckets, counts.

        Returns
        -------
        (...) float64
            mm; inf where the amplitude is 0.
        """
        A = np.asarray(amplitude, np.float64)
        weight = (2.0 * np.pi * A) ** 2 * np.sum(1.0 / self.ambiguities_mm() ** 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.amplitude_sigma(mean) / np.sqrt(weight)

    def amplitude_sigma(self, mean: ArrayLike) -> Float64:
        r"""Standard deviation of either component of the phasor.

        .. math:: \sqrt{2 (B + r^2 + q^2 / 12) / N}

        with the read noise r and the converter's step q; 1 for the "paper" principle.

        Parameters
        ----------
        mean : (...) array_like
            Mean B of the buckets, counts.

        Returns
        -------
        (...) float64
            Counts.
        """
        B = np.asarray(mean, np.float64)
        if self.principle == "paper":
            return np.ones_like(B)
        variance = self.shot_noise * np.maximum(B, 0.0) + self.read_noise**2
        return np.sqrt(2.0 * (variance + self.converter_step**2 / 12.0) / self.phases)

    @property
    def converter_step(self) -> float:
        """Counts per step of the converter; 0 = it does not round."""
        on = self.bits > 0 and np.isfinite(self.full_well)
        return self.full_well / (2**self.bits - 1) if on else 0.0

    def depth_sigma(self, depth_mm: ArrayLike) -> Float64:
        """Noise law of "triangulation": floor + quadratic · z², mm."""
        return self.floor_mm + self.quadratic_per_mm * np.asarray(depth_mm, np.float64) ** 2

    def without(self, *effects: str) -> SensorModel:
        """The same sensor with the named effects switched off.

        Raises
        ------
        ParameterError
            An unknown effect; the message lists the known ones.
        """
        changes: dict[str, Any] = {}
        for effect in effects:
            if effect not in EFFECTS:
                raise ParameterError(f"effects: unknown {effect!r}; known: {', '.join(EFFECTS)}")
            changes.update(EFFECTS[effect])
        return replace(self, **changes)

    def ideal(self) -> SensorModel:
        """The same sensor with every effect switched off."""
        return self.without(*EFFECTS)


_NOT_NEGATIVE = (
    "lobe_power", "background", "dark", "jitter_rad", "modulation_error", "read_noise", "bits",
    "third_harmonic", "fifth_harmonic", "fixed_pattern_mm", "gain_pattern", "vignetting", "device",
    "floor_mm", "quadratic_per_mm", "step_per_mm", "min_snr", "min_amplitude",
)  # fmt: skip
