"""Enrolling a person from the live view: ahead, a little left, a little right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rangeface.pipeline import Trace
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Reason, Template

_NEEDED = 4  # looks of each side
_AHEAD_DEG, _ASIDE_DEG = 6.0, 25.0

#: Side → what it is called, what is said to get there, and which yaw it takes.
_SIDES: dict[str, tuple[str, str, Callable[[float], bool]]] = {
    "ahead": ("Looking ahead", "Look straight ahead", lambda yaw: abs(yaw) <= _AHEAD_DEG),
    "left": ("Turned left", "Turn a little to your left",
             lambda yaw: _AHEAD_DEG < yaw <= _ASIDE_DEG),
    "right": ("Turned right", "Turn a little to your right",
              lambda yaw: -_ASIDE_DEG <= yaw < -_AHEAD_DEG),
}  # fmt: skip

_ADVICE = {
    Reason.TOO_NOISY: "Come closer",
    Reason.DISTANCE: "Come closer, or step back a little",
    Reason.POSE: "Look towards the camera",
    Reason.LOW_OVERLAP: "Show your whole face",
    Reason.POOR_FIT: "Hold still, and show your whole face",
    Reason.NOT_CONVERGED: "Hold still",
    Reason.TOO_FEW_POINTS: "Come closer",
}
_GONE = "Come back into view"
_HOLD = "Hold still"


@dataclass
class Enrolment:
    """What has been collected of one person.

    Parameters
    ----------
    subject : str
        Name to be.
    track : int
        The face that is enrolled, and no other, even where another comes into view.
    """

    subject: str
    track: int
    hint: str = _HOLD
    _looks: dict[str, list[Trace]] = field(default_factory=lambda: {side: [] for side in _SIDES})

    @property
    def sufficient(self) -> bool:
        """Whether there is enough to recognise the person by."""
        return len(self._looks["ahead"]) >= _NEEDED

    @property
    def complete(self) -> bool:
        """Whether every side has been seen."""
        return all(len(looks) >= _NEEDED for looks in self._looks.values())

    def take(self, look: Trace | None) -> None:
        """Take what was seen of the face, None where it was not; say what to do next."""
        if look is None:
            self.hint = _GONE
            return
        if look.frontal is None or look.assessment is None or not look.assessment.usable:
            reasons = look.assessment.refusals if look.assessment else (look.reason,)
            self.hint = _ADVICE.get(reasons[0], _HOLD) if reasons[0] else _HOLD
            return
        for side, (_, _, takes) in _SIDES.items():
            if takes(look.assessment.yaw_deg) and len(self._looks[side]) < _NEEDED:
                self._looks[side].append(look)
        missing = next((s for s, looks in self._looks.items() if len(looks) < _NEEDED), None)
        self.hint = "Done" if missing is None else _SIDES[missing][1]

    def template(self, recognizer: FaceRecognizer) -> Template:
        """One template: the views ahead with their rotations, and one of each side.

        Each is the mean over its looks, so that their noise averages out.
        """
        made = [
            [recognizer.template(look, augment=side == "ahead").vectors for look in looks]
            for side, looks in self._looks.items()
            if looks
        ]
        heads = range(len(made[0][0]))
        vectors = tuple(
            np.concatenate([np.mean([look[h] for look in looks], axis=0) for looks in made])
            for h in heads
        )
        best = self._looks["ahead"][-1]
        return Template(vectors, recognizer.pipeline.fingerprint, best.assessment)

    def as_dict(self) -> dict[str, Any]:
        """For the page."""
        steps = [
            {"label": _SIDES[side][0], "done": len(looks), "needed": _NEEDED}
            for side, looks in self._looks.items()
        ]
        return {"subject": self.subject, "track": self.track, "hint": self.hint, "steps": steps,
                "sufficient": self.sufficient}  # fmt: skip
