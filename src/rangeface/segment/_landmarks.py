"""Nose root, eye corners, forehead and chin from a face's own profile and curvature."""

from __future__ import annotations

import numpy as np

from rangeface.errors import NoFaceError
from rangeface.io.reference import default_reference
from rangeface.numerics import curvature, gaussian
from rangeface.segment._rectangle import rectangle
from rangeface.types import Alignment, Face, Float64, Orthographic, RangeImage, ReferenceFace

#: The frontal image that is searched.
_WIDTH_MM, _HEIGHT_MM, _PITCH_MM = 140.0, 220.0, 2.0
#: Half width of the profile's band, mm.
_BAND_MM = 5.0
#: Bounds of the searches, mm around the reference's place, and how far people lie from it.
_ROOT_MM, _ROOT_SPREAD_MM = 20.0, 15.0
_CHIN_MM, _CHIN_SPREAD_MM = 20.0, 6.0
_EYE_MM, _EYE_SPREAD_MM = 13.0, 8.0
#: A corner of the eye is the hollowest place of this radius; 1 / 60 mm weighs as one spread.
_EYE_RADIUS_MM, _HOLLOW_MM = 10.0, 60.0
#: The forehead is read this far above the nose root, mm.
_FOREHEAD_MM = 30.0


def landmarks(
    face: Face, alignment: Alignment, *, reference: ReferenceFace | None = None
) -> dict[str, Float64]:
    """Landmarks of a registered face, sought about the reference's.

    The nose root (sellion) is where the profile lies furthest behind the chord from the brow to
    the bridge, the chin (pogonion) its most protruding point below the lips. The inner corners
    of the eyes are the hollowest places (mean curvature) beside the root, the same on both sides,
    as far as both are seen; the outer corners, of which depth shows little, keep their place to the
    inner ones. The forehead is the profile 30 mm above the nose root. Every search is held near the
    reference's landmark by a quadratic penalty.

    Parameters
    ----------
    face : Face
        The crop, camera frame.
    alignment : Alignment
        Converged; best of `register.symmetric`: its x = 0 is the face's own middle.
    reference : ReferenceFace, optional
        Default: the reference that ships with the package. Needs the landmarks' names.

    Returns
    -------
    dict of str to (3,) float64
        nose_tip, nose_root, forehead, chin, left and right eye_inner and eye_outer; camera frame,
        mm. What is hidden keeps the reference's place, moved as the nose root was.

    Raises
    ------
    NoFaceError
        The alignment was refused, or no point lies in the frontal rectangle.
    """
    if not alignment.converged:
        raise NoFaceError(f"no landmarks of a refused alignment: {alignment.reason}")
    known = (default_reference() if reference is None else reference).landmarks
    frontal = rectangle(
        face.image, alignment.transform, width_mm=_WIDTH_MM, height_mm=_HEIGHT_MM,
        width=round(_WIDTH_MM / _PITCH_MM), height=round(_HEIGHT_MM / _PITCH_MM),
    )  # fmt: skip
    y, profile = _profile(frontal)
    root = known["nose_root"] + [0.0, _hollowest(y, profile, known["nose_root"][1]), 0.0]
    moved = {name: place + (root - known["nose_root"]) for name, place in known.items()}
    upper = frontal.crop(0, 0, frontal.shape[1], frontal.shape[0] // 2)
    right, left = _inner_corners(upper, moved["right_eye_inner"], moved["left_eye_inner"])
    found = {
        "nose_tip": np.zeros(3),
        "nose_root": root,
        "forehead": root - [0.0, _FOREHEAD_MM, 0.0],
        "chin": known["chin"] + [0.0, _foremost(y, profile, known["chin"][1]), 0.0],
        "right_eye_inner": right,
        "left_eye_inner": left,
        "right_eye_outer": right + known["right_eye_outer"] - known["right_eye_inner"],
        "left_eye_outer": left + known["left_eye_outer"] - known["left_eye_inner"],
    }
    camera_face = alignment.transform.inverse()
    return {
        name: camera_face.apply(place if name == "nose_tip" else _on_surface(frontal, place))
        for name, place in found.items()
    }


def _profile(frontal: RangeImage) -> tuple[Float64, Float64]:
    """Heights, mm, and depths of the band about the middle; NaN where it shows nothing."""
    x, y = _axes(frontal)
    band = frontal.depth[:, np.abs(x) <= _BAND_MM]
    valid = np.isfinite(band)
    sums, counts = np.where(valid, band, 0.0).sum(axis=1), valid.sum(axis=1)
    depth = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
    return y, gaussian.smooth(depth[None], 1.0)[0].astype(np.float64)


def _axes(frontal: RangeImage) -> tuple[Float64, Float64]:
    """Where the columns and rows lie, mm from the nose tip."""
    camera = frontal.camera
    assert isinstance(camera, Orthographic)
    x = (np.arange(camera.width, dtype=np.float64) - camera.cx) * camera.pitch_mm
    y = (np.arange(camera.height, dtype=np.float64) - camera.cy) * camera.pitch_mm
    return x, y


def _hollowest(y: Float64, profile: Float64, expected: float) -> float:
    """How far below the expected height the profile lies furthest behind its own chord."""
    near = np.isfinite(profile) & (np.abs(y - expected) <= _ROOT_MM)
    if near.sum() < 5:
        return 0.0
    y, z = y[near], profile[near]
    chord = z[0] + (z[-1] - z[0]) / (y[-1] - y[0]) * (y - y[0])
    return float(y[(z - chord - ((y - expected) / _ROOT_SPREAD_MM) ** 2).argmax()] - expected)


def _foremost(y: Float64, profile: Float64, expected: float) -> float:
    """How far below the expected height the profile protrudes most."""
    near = np.isfinite(profile) & (np.abs(y - expected) <= _CHIN_MM)
    if near.sum() < 5:
        return 0.0
    y, z = y[near], profile[near]
    return float(y[(z + ((y - expected) / _CHIN_SPREAD_MM) ** 2).argmin()] - expected)


def _inner_corners(frontal: RangeImage, right: Float64, left: Float64) -> tuple[Float64, Float64]:
    """The inner corners, from where both sides together are hollowest about the expected left."""
    x, y = _axes(frontal)
    _, bulge = curvature.by_fit(
        frontal.depth, _PITCH_MM, radius=_EYE_RADIUS_MM, sigma=frontal.sigma
    )
    both = np.stack([bulge, bulge[:, ::-1]])
    seen = np.isfinite(both)
    hollow = -np.where(seen, both, 0.0).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
    away = (x - left[0]) ** 2 + (y[:, None] - left[1]) ** 2
    searched = seen.any(axis=0) & (away <= _EYE_MM**2)
    if not searched.any():
        return right, left
    score = np.where(searched, _HOLLOW_MM * hollow - away / _EYE_SPREAD_MM**2, -np.inf)
    row, column = np.unravel_index(score.argmax(), score.shape)
    move = np.array([x[column] - left[0], y[row] - left[1], 0.0])
    return right + move * [-1.0, 1.0, 1.0], left + move


def _on_surface(frontal: RangeImage, place: Float64) -> Float64:
    """The place, at the depth of the surface there; as it is where none was measured."""
    column, row = np.rint(frontal.camera.project(place)).astype(int)
    height, width = frontal.shape
    if not (0 <= column < width and 0 <= row < height and np.isfinite(frontal.depth[row, column])):
        return place
    return np.array([place[0], place[1], frontal.depth[row, column]])
