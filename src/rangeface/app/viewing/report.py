"""What the page is told about a frame."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rangeface.app.viewing.wire import Plane, encode
from rangeface.live import LiveFrame, TrackView
from rangeface.types import Orthographic, RangeImage

_DEPTH_STEP_MM, _SURFACE_STEP_MM = 0.25, 0.05
_DECIMALS = 3
_WIDTH, _HEIGHT = 0.72, 0.94  # a head in the square that a track reports


def report(
    number: int,
    image: RangeImage,
    seen: LiveFrame,
    *,
    fps: float,
    followed: int | None,
    surface: tuple[int, RangeImage] | None,
    times_ms: Mapping[str, float],
) -> bytes:
    """A frame and what was seen in it, as `wire.encode` packs it.

    Parameters
    ----------
    number : int
        Of the frame, counted over all sources.
    image : RangeImage
        What is shown.
    seen : LiveFrame
    fps : float
        Frames a second that were looked at.
    followed : int, optional
        Number of the track that is shown close up.
    surface : (int, RangeImage), optional
        Number of a track, and its frontal image.
    times_ms : mapping
        Stage → ms.
    """
    head = {
        "frame": number,
        "time_s": seen.time_s,
        "fps": _number(fps),
        "latency_ms": _number(seen.latency_ms),
        "dropped": seen.dropped,
        "ignored": seen.ignored,
        "people": seen.people,
        "followed": followed,
        "times_ms": {stage: _number(time) for stage, time in times_ms.items()},
        "faces": [_face(track) for track in seen.tracks],
    }
    planes = [Plane("depth", image.depth, _DEPTH_STEP_MM, {})]
    if surface is not None:
        track, frontal = surface
        assert isinstance(frontal.camera, Orthographic)
        place = {"track": track, "pitch_mm": frontal.camera.pitch_mm}
        planes.append(Plane("surface", frontal.depth, _SURFACE_STEP_MM, place))
    return encode(head, planes)


def _face(track: TrackView) -> dict[str, Any]:
    left, top, right, bottom = track.box
    width, height = right - left, bottom - top
    return {
        "track": track.number,
        "box": [left + 0.5 * (1 - _WIDTH) * width, top, _WIDTH * width, _HEIGHT * height],
        "verdict": track.verdict,
        "subject": track.subject,
        "score": _number(track.score),
        "threshold": _number(track.threshold),
        "refuse_at": _number(track.refuse_at),
        "reason": track.reason,
        "looks": track.looks,
        "evidence": [[_number(t), _number(e)] for t, e in track.evidence],
        "yaw_deg": _number(track.yaw_deg),
        "pitch_deg": _number(track.pitch_deg),
        "distance_mm": _number(track.nose_tip_mm[2]),
        "visits": track.visits,
    }


def _number(value: float) -> float | None:
    """For JSON, which has no word for what is not finite."""
    return round(float(value), _DECIMALS) if math.isfinite(value) else None
