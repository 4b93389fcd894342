"""The rigid map of three or more landmarks onto those of the reference face."""

from __future__ import annotations

import numpy as np

from rangeface.errors import DegenerateError, ParameterError
from rangeface.io.reference import default_reference
from rangeface.numerics.se3 import best_fit
from rangeface.types import Alignment, Face, Reason, ReferenceFace, RigidTransform


def landmarks(
    face: Face,
    *,
    reference: ReferenceFace | None = None,
    names: tuple[str, ...] = ("left_eye_outer", "right_eye_outer", "nose_tip"),
    max_rms_mm: float = 12.0,
) -> Alignment:
    """Turn a face frontal, roughly, by a few of its landmarks.

    Parameters
    ----------
    face : Face
        Its `landmarks`, or for "nose_tip" its nose tip, are mapped onto the reference's.
    reference : ReferenceFace, optional
        Default: the reference that ships with the package.
    names : tuple of str
        At least three landmarks of the reference.
    max_rms_mm : float
        A larger residual of the landmarks is refused: they are not those of a face.

    Returns
    -------
    Alignment
        `rms_mm` over the landmarks. Refused where one is missing (too few points), where they
        lie on a line (not converged), or do not fit.

    Raises
    ------
    ParameterError
        Fewer than three names, or one that the reference does not have.

    References
    ----------
    S. Umeyama, IEEE TPAMI 13(4), 1991, doi:10.1109/34.88573.
    """
    reference = default_reference() if reference is None else reference
    unknown = [name for name in names if name not in reference.landmarks]
    if len(names) < 3 or unknown:
        known = ", ".join(sorted(reference.landmarks))
        raise ParameterError(f"names: three or more of {known}; got {', '.join(names)}")
    own = {"nose_tip": face.nose_tip, **face.landmarks}
    if any(name not in own for name in names):
        return _refused(face, Reason.TOO_FEW_POINTS)
    found = np.array([own[name] for name in names])
    wanted = np.array([reference.landmarks[name] for name in names])
    try:
        transform = RigidTransform(*best_fit(found, wanted))
    except DegenerateError:
        return _refused(face, Reason.NOT_CONVERGED)
    rms = float(np.sqrt(((transform.apply(found) - wanted) ** 2).sum(axis=1).mean()))
    fits = rms <= max_rms_mm
    return Alignment(
        transform, rms, inliers=len(names), converged=fits,
        reason=None if fits else Reason.POOR_FIT,
    )  # fmt: skip


def _refused(face: Face, reason: Reason) -> Alignment:
    moved = RigidTransform(np.eye(3), -face.nose_tip)
    return Alignment(moved, converged=False, reason=reason)
