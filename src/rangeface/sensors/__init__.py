"""Range sensors: what they are (presets with their sources), and how one is calibrated."""

from rangeface.sensors._calibration import Calibration, calibrate
from rangeface.sensors._model import EFFECTS, PRINCIPLES, SPEED_OF_LIGHT_MM_S, SensorModel
from rangeface.sensors._presets import PRESETS, preset

__all__ = [
    "EFFECTS",
    "PRESETS",
    "PRINCIPLES",
    "SPEED_OF_LIGHT_MM_S",
    "Calibration",
    "SensorModel",
    "calibrate",
    "preset",
]
