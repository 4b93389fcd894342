"""The questions that every denoiser asks of its parameters."""

from __future__ import annotations

import math

from rangeface.errors import ParameterError


def positive(name: str, value: float) -> None:
    """Refuse a parameter that is not positive and finite."""
    if not (math.isfinite(value) and value > 0):
        raise ParameterError(f"{name} must be > 0 and finite, got {value}")


def not_negative(name: str, value: float) -> None:
    """Refuse a parameter that is negative or not finite."""
    if not (math.isfinite(value) and value >= 0):
        raise ParameterError(f"{name} must be ≥ 0 and finite, got {value}")


def fraction(name: str, value: float) -> None:
    """Refuse a parameter outside 0 … 1."""
    if not 0.0 <= value <= 1.0:
        raise ParameterError(f"{name} must lie in 0 … 1, got {value}")


def odd(name: str, value: int) -> None:
    """Refuse a window width that has no centre, or that smooths nothing."""
    if value < 3 or value % 2 == 0:
        raise ParameterError(f"{name} must be odd and ≥ 3, got {value}")
