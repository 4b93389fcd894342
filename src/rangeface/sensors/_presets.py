"""Sensors by name.

Where a maker publishes no number the value is assumed, of the size that its class of sensor
shows; each preset's `source` says what is published.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from rangeface.errors import ParameterError
from rangeface.sensors._model import SensorModel
from rangeface.types import Pinhole


def _field_of_view(width: int, height: int, across_deg: float, down_deg: float) -> Pinhole:
    fx, fy = (
        0.5 * n / np.tan(np.radians(0.5 * a)) for n, a in ((width, across_deg), (height, down_deg))
    )
    return Pinhole(float(fx), float(fy), 0.5 * (width - 1), 0.5 * (height - 1), width, height)


PRESETS: Mapping[str, SensorModel] = MappingProxyType(
    {
        sensor.name: sensor
        for sensor in (
            SensorModel(
                "sr3000",
                "MESA SR-3000 (T. Oggier et al., 1st Range Imaging Research Day, ETH Zurich, 2005; "
                "176 × 144, 47.5° × 39.6°, 20 MHz, four phases); counts and errors assumed.",
                _field_of_view(176, 144, 47.5, 39.6),
                frequencies_hz=(20e6,), signal=26_000.0, contrast=0.45, lobe_power=2.0,
                background=30_000.0, dark=2_000.0, jitter_rad=2e-4, modulation_error=2e-4,
                read_noise=60.0, full_well=1.6e6, compression=0.02, bits=12, third_harmonic=0.01,
                fifth_harmonic=0.003, multipath=0.01, bounce=0.03, scattering=0.04,
                scattering_px=18.0, fixed_pattern_mm=2.0, gain_pattern=0.01, vignetting=4.0,
                dead_pixels=2e-4, min_amplitude=7_000.0,
            ),
            SensorModel(
                "kinect-v2",
                "Microsoft Kinect v2 (J. Sell, P. O'Connor, IEEE Micro 34(2), 2014, "
                "doi:10.1109/MM.2014.9): 512 × 424, 80 and 16 MHz of its three frequencies, "
                "nominal fx = fy = 365.5; counts and errors assumed.",
                Pinhole(365.5, 365.5, 255.5, 211.5, 512, 424),
                frequencies_hz=(80e6, 16e6), phases=3, signal=30_000.0, contrast=0.6,
                lobe_power=1.0, background=500.0, dark=200.0, jitter_rad=2e-4, read_noise=30.0,
                full_well=6e5, bits=12, third_harmonic=0.006, multipath=0.006, scattering=0.02,
                scattering_px=25.0, fixed_pattern_mm=0.8, gain_pattern=0.01, vignetting=4.0,
                dead_pixels=1e-4, min_amplitude=1_200.0,
            ),
            SensorModel(
                "pmd-flexx2",
                "pmd flexx2 class (maker's data sheet: 224 × 172, 56° × 44°, 0.1 – 4 m, 940 nm); "
                "frequencies, counts and errors assumed.",
                _field_of_view(224, 172, 56.0, 44.0),
                frequencies_hz=(60e6, 80e6), signal=7_000.0, contrast=0.6, lobe_power=0.5,
                background=400.0, dark=150.0, jitter_rad=3e-4, read_noise=20.0, full_well=3e5,
                bits=12, third_harmonic=0.008, multipath=0.006, scattering=0.03,
                scattering_px=15.0, fixed_pattern_mm=1.0, gain_pattern=0.01, vignetting=3.0,
                dead_pixels=1e-4, min_amplitude=600.0,
            ),
            SensorModel(
                "femto",
                "Azure Kinect / Femto class (C. S. Bamji et al., ISSCC 2018, "
                "doi:10.1109/ISSCC.2018.8310200; 640 × 576 narrow field 75° × 65°, fx = 504); "
                "200 and 320 MHz; counts and errors assumed.",
                Pinhole(504.0, 504.0, 319.5, 287.5, 640, 576),
                frequencies_hz=(200e6, 320e6), phases=3, signal=5_000.0, contrast=0.75,
                lobe_power=0.5, background=300.0, dark=100.0, jitter_rad=4e-4, read_noise=15.0,
                full_well=1e5, bits=12, third_harmonic=0.006, multipath=0.005, scattering=0.01,
                scattering_px=25.0, fixed_pattern_mm=0.5, gain_pattern=0.01, vignetting=3.0,
                dead_pixels=1e-4, min_amplitude=250.0,
            ),
            SensorModel(
                "paper",
                "The source paper's simulation on an SR-3000: the angle of a normally distributed "
                "point in the plane at distance A from the origin, σ_φ = 1/A.",
                _field_of_view(176, 144, 47.5, 39.6),
                principle="paper", frequencies_hz=(20e6,), signal=80.0,
            ),
            SensorModel(
                "laser-scanner",
                "Light-stripe scanner of the class behind GavabDB (Minolta VI-700; A. B. Moreno, "
                "A. Sánchez, 2004): about 1.4 mm between points; noise assumed 0.2 mm.",
                _field_of_view(400, 400, 20.0, 20.0),
                principle="triangulation", floor_mm=0.2,
            ),
            SensorModel(
                "structured-light",
                "First Kinect (K. Khoshelham, S. O. Elberink, Sensors 12(2), 2012, "
                "doi:10.3390/s120201437): σ = 1.425e-6 z², disparity step 2.85e-6 z² (mm).",
                Pinhole(585.0, 585.0, 319.5, 239.5, 640, 480),
                principle="triangulation", quadratic_per_mm=1.425e-6, step_per_mm=2.85e-6,
            ),
        )
    }
)  # fmt: skip


def preset(name: str) -> SensorModel:
    """The named preset.

    Parameters
    ----------
    name : str
        One of `PRESETS`.

    Returns
    -------
    SensorModel
        Vary it with `dataclasses.replace` and `SensorModel.without`.

    Raises
    ------
    ParameterError
        An unknown name; the message lists the known ones.

    Examples
    --------
    >>> preset("kinect-v2").camera.width
    512
    """
    if name not in PRESETS:
        raise ParameterError(f"sensor: unknown preset {name!r}; known: {', '.join(PRESETS)}")
    return PRESETS[name]
