"""What the live recogniser says about a frame: plain values, ready for JSON."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

from rangeface.types import Reason, Verdict


@dataclass(frozen=True)
class TrackView:
    """One face that is followed.

    Parameters
    ----------
    number : int
        Of the track; never used again.
    box : tuple of int
        left, top, right, bottom, px; right and bottom are outside.
    nose_tip_mm : tuple of float
        Camera frame.
    yaw_deg, pitch_deg, roll_deg : float
        Of the head.
    since_s : float
        Time of the frame in which the track began.
    lost_s : float
        So long it has not been seen; 0: it is in this frame.
    verdict : Verdict
        Accepted, unknown, or cannot tell (yet).
    subject : str, optional
        Who was recognised.
    score : float
        Evidence for the best person: accumulated log-likelihood ratio.
    threshold : float
        The evidence that is needed.
    refuse_at : float
        Below it everybody is ruled out: unknown.
    reason : Reason, optional
        Why there is no name.
    ranking : tuple of (str, float)
        The best people and their evidence.
    looks : int
        Looks that were compared.
    evidence : tuple of (float, float)
        Time (s) and evidence for the best person, look by look.
    person : int, optional
        Number of the person, who may have been here before; None while that is open.
    visits : int
        How often this person has come, this time included.
    """

    number: int
    box: tuple[int, int, int, int]
    nose_tip_mm: tuple[float, float, float]
    yaw_deg: float
    pitch_deg: float
    roll_deg: float
    since_s: float
    lost_s: float
    verdict: Verdict
    subject: str | None
    score: float
    threshold: float
    refuse_at: float
    reason: Reason | None
    ranking: tuple[tuple[str, float], ...]
    looks: int
    evidence: tuple[tuple[float, float], ...]
    person: int | None = None
    visits: int = 0


@dataclass(frozen=True)
class LiveFrame:
    """What is known after one frame.

    Parameters
    ----------
    number : int
        Of the frame.
    time_s : float
        Of the frame, by the camera's clock.
    latency_ms : float
        From the frame's arrival to this answer.
    tracks : tuple of TrackView
        Everybody who is followed, oldest track first.
    people : int
        Different people seen so far.
    times_ms : mapping of str to float
        Stage → milliseconds; "search" is the background's last one.
    dropped : int
        Frames thrown away before this one, because newer ones had come.
    ignored : int
        Frames that were too old, doubled or out of order.
    stale : bool
        This frame was one of those: the tracks are those of the last good one.
    """

    number: int
    time_s: float
    latency_ms: float
    tracks: tuple[TrackView, ...]
    people: int = 0
    times_ms: dict[str, float] = field(default_factory=dict)
    dropped: int = 0
    ignored: int = 0
    stale: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: a number that is not finite becomes None."""
        plain: dict[str, Any] = _plain(asdict(self))
        return plain


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
