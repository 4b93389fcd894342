"""What an iteration of closest points found, as an Alignment."""

from __future__ import annotations

from rangeface.numerics.icp import Fit
from rangeface.types import Alignment, Reason, RigidTransform


def outcome(fit: Fit, transform: RigidTransform, reason: Reason | None) -> Alignment:
    """The Alignment of a fit; refused where there is a reason."""
    return Alignment(
        transform=transform,
        rms_mm=fit.rms_mm,
        overlap=fit.overlap,
        inliers=fit.inliers,
        condition=fit.condition,
        converged=reason is None,
        reason=reason,
    )
