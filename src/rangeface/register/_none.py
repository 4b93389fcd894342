"""No registration: the unregistered crop of the paper's Tables 1 to 3."""

from __future__ import annotations

import numpy as np

from rangeface.types import Alignment, Face, RigidTransform


def none(face: Face) -> Alignment:
    """Leave the face as the camera sees it; only move its nose tip to the origin.

    Parameters
    ----------
    face : Face
        With its nose tip.

    Returns
    -------
    Alignment
        Rotation I, translation −nose tip; no residual is claimed.
    """
    return Alignment(RigidTransform(np.eye(3), -face.nose_tip))
