"""Pose, coverage, fit, noise, distance: measured, and held against limits."""

from __future__ import annotations

import numpy as np

from rangeface.errors import ParameterError
from rangeface.types import Alignment, Assessment, Face, RangeImage, Reason


def quality(
    face: Face,
    alignment: Alignment,
    frontal: RangeImage,
    *,
    max_yaw_deg: float = 60.0,
    max_pitch_deg: float = 45.0,
    max_roll_deg: float = 45.0,
    min_coverage: float = 0.35,
    min_overlap: float = 0.3,
    min_correlation: float = 0.4,
    max_sigma_mm: float = 20.0,
    min_distance_mm: float = 100.0,
    max_distance_mm: float = 5000.0,
) -> Assessment:
    """Measure what a decision should depend on; name every limit that is exceeded.

    Parameters
    ----------
    face : Face
        As found.
    alignment : Alignment
        As registered.
    frontal : RangeImage
        As resampled.
    max_yaw_deg, max_pitch_deg, max_roll_deg : float
        Largest angles of the head, > 0.
    min_coverage : float
        0 … 1: least measured part of the frontal grid.
    min_overlap, min_correlation : float
        Least overlap and relief correlation with the reference (where registration gave them).
    max_sigma_mm : float
        Largest median σ of the frontal depth, mm (where known).
    min_distance_mm, max_distance_mm : float
        Working range of the nose tip, mm; not applied to parallel projections.

    Returns
    -------
    Assessment

    Raises
    ------
    ParameterError
        A limit is not positive, or the distances are in the wrong order.
    """
    limits = {
        "max_yaw_deg": max_yaw_deg,
        "max_pitch_deg": max_pitch_deg,
        "max_roll_deg": max_roll_deg,
        "max_sigma_mm": max_sigma_mm,
    }
    for name, limit in limits.items():
        if not limit > 0:
            raise ParameterError(f"{name} must be > 0, got {limit}")
    if not min_distance_mm < max_distance_mm:
        raise ParameterError("min_distance_mm must be below max_distance_mm")

    yaw, pitch, roll = np.rad2deg(alignment.transform.head_angles)
    measured = frontal.mask if frontal.filled is None else frontal.mask & ~frontal.filled
    coverage = float(measured.mean())
    sigma = float("nan")
    if frontal.sigma is not None and measured.any():
        sigma = float(np.median(frontal.sigma[measured]))
    distance = float(face.nose_tip[2])
    perspective = face.image.camera.projection.perspective
    violated = {
        Reason.POSE: any(abs(a) > most for a, most in ((yaw, max_yaw_deg), (pitch, max_pitch_deg),
                                                       (roll, max_roll_deg))),
        Reason.LOW_OVERLAP: coverage < min_coverage or alignment.overlap < min_overlap,
        Reason.POOR_FIT: alignment.correlation < min_correlation,
        Reason.TOO_NOISY: sigma > max_sigma_mm,
        Reason.DISTANCE: perspective and not min_distance_mm <= distance <= max_distance_mm,
    }  # fmt: skip
    return Assessment(
        yaw_deg=float(yaw),
        pitch_deg=float(pitch),
        roll_deg=float(roll),
        coverage=coverage,
        overlap=alignment.overlap,
        sigma_mm=sigma,
        distance_mm=distance,
        rms_mm=alignment.rms_mm,
        correlation=alignment.correlation,
        refusals=tuple(reason for reason, is_violated in violated.items() if is_violated),
    )
