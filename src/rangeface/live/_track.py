"""One face, from when it is found until it is lost."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rangeface.decide import refuse, sequential
from rangeface.gallery import View
from rangeface.live._box import box
from rangeface.live._evidence import Evidence
from rangeface.live._together import together
from rangeface.live._view import TrackView
from rangeface.live._visits import Point, Visit
from rangeface.pipeline import FacePipeline, Trace
from rangeface.recognizer import FaceRecognizer
from rangeface.segment import follow
from rangeface.types import (
    Decision,
    Float64,
    RangeImage,
    Reason,
    RigidTransform,
    Template,
    Verdict,
)

_BOX_MM = 105.0
#: Looks that count: what was seen before may have been somebody else.
_LOOKS = 12


@dataclass(frozen=True)
class Rules:
    """How evidence becomes a decision; see `LiveRecognizer`."""

    fpir: float
    fnir: float
    correlation: float
    combined: int

    def __post_init__(self) -> None:
        nobody = np.empty((0, 0))  # the test itself knows its limits
        sequential(nobody, (), fpir=self.fpir, fnir=self.fnir, correlation=self.correlation)


@dataclass(frozen=True)
class Look:
    """One comparison: when, the template, or why there is none."""

    time_s: float
    template: Template | None
    reason: Reason | None = None


@dataclass(eq=False)
class Track:
    """A face that is followed: where it is, what has been seen of it, what was decided."""

    number: int
    pose: RigidTransform
    since_s: float
    seen_s: float
    box: tuple[int, int, int, int] = (0, 0, 0, 0)
    decision: Decision = field(default_factory=lambda: refuse(Reason.TOO_FEW_FRAMES))
    person: int | None = None
    visits: int = 0
    looks: deque[Look] = field(default_factory=lambda: deque(maxlen=_LOOKS))
    looked: int = 0
    since_look: int = 0
    evidence: list[tuple[float, float]] = field(default_factory=list)
    first_mm: Float64 | None = None
    _recent: deque[tuple[RangeImage, RigidTransform]] = field(default_factory=lambda: deque())
    _rows: list[Float64] = field(default_factory=list)
    _view: View | None = None

    @property
    def nose_tip(self) -> Float64:
        """In the camera frame, mm."""
        return self.pose.inverse().translation

    @property
    def recent(self) -> int:
        """Frames in a row, up to those that a look combines."""
        return len(self._recent)

    @property
    def usable(self) -> int:
        """Looks that could be compared."""
        return sum(look.template is not None for look in self.looks)

    @property
    def decided(self) -> bool:
        """Whether the evidence sufficed for a name or for *unknown*."""
        return self.decision.verdict is not Verdict.CANNOT_TELL

    def advance(
        self, pipeline: FacePipeline, image: RangeImage, time_s: float, combined: int
    ) -> bool:
        """Find the face in the next frame; False where it is not to be found."""
        faces = follow(image, self.pose, reference=pipeline.reference)
        if not faces or faces[0].pose is None:
            self._recent.clear()
            return False
        self.pose, self.seen_s = faces[0].pose, time_s
        self.since_look += 1
        self.box = box(image, self.nose_tip, _BOX_MM)
        if self.first_mm is None:
            self.first_mm = self.nose_tip
        if self._recent and self._recent[0][0].camera != image.camera:
            self._recent.clear()
        self._recent.appendleft((image, self.pose))
        while len(self._recent) > combined:
            self._recent.pop()
        return True

    def look(self, recognizer: FaceRecognizer) -> Look:
        """What the last frames show together, as a template."""
        self.since_look = 0
        return self._template(recognizer)

    def learn(
        self, look: Look, recognizer: FaceRecognizer, view: View, evidence: Evidence, rules: Rules
    ) -> None:
        """Compare a look with the gallery, and decide on all that was seen."""
        self.looked += 1
        self.looks.append(look)
        self.judge(recognizer, view, evidence, rules)
        if self.looks[-1].template is not None and np.isfinite(self.decision.score):
            self.evidence = [*self.evidence[-99:], (self.seen_s, self.decision.score)]

    def judge(
        self, recognizer: FaceRecognizer, view: View, evidence: Evidence, rules: Rules
    ) -> None:
        """Decide on the looks so far; all are compared again where the gallery has changed."""
        if view is not self._view:
            self._rows, self._view = [], view
            pending: Sequence[Look] = self.looks
        else:
            pending = [self.looks[-1]]
        for look in pending:
            row = np.full(len(view.subjects), np.nan)
            if look.template is not None:
                row = evidence(recognizer.scores(look.template, view))
            self._rows.append(row)
        self._rows = self._rows[-len(self.looks) :]
        usable = [look for look in self.looks if look.template is not None]
        if not usable:
            self.decision = refuse(self.looks[-1].reason or Reason.TOO_FEW_FRAMES)
            return
        table = np.array(self._rows).reshape(len(self._rows), len(view.subjects))
        self.decision = sequential(
            table, view.subjects, fpir=rules.fpir, fnir=rules.fnir, correlation=rules.correlation
        ).decision

    def template(self, pipeline: FacePipeline) -> Template | None:
        """The mean of all looks; of a head that compares surfaces as they are, the last look."""
        seen = [look.template.vectors for look in self.looks if look.template is not None]
        if not seen:
            return None
        rows = []
        for head, looks in zip(pipeline.heads, zip(*seen, strict=True), strict=True):
            mean = head.classify.needs_rotated_views and all(len(look) for look in looks)
            rows.append(np.mean(np.concatenate(looks), axis=0)[None] if mean else looks[-1])
        return Template(tuple(rows), pipeline.fingerprint)

    def visit(self, pipeline: FacePipeline) -> Visit:
        """What is to be remembered when it is over."""
        first = self.nose_tip if self.first_mm is None else self.first_mm
        return Visit(
            self.number, self.person, self.decision.subject, self.decision.verdict,
            self.since_s, self.seen_s, _point(first), _point(self.nose_tip), self.looked,
            self.template(pipeline),
        )  # fmt: skip

    def view(self, time_s: float, rules: Rules) -> TrackView:
        """What is to be shown."""
        yaw, pitch, roll = (float(np.rad2deg(a)) for a in self.pose.head_angles)
        d = self.decision
        return TrackView(
            number=self.number, box=self.box, nose_tip_mm=_point(self.nose_tip),
            yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll,
            since_s=self.since_s, lost_s=time_s - self.seen_s,
            verdict=d.verdict, subject=d.subject, score=d.score, threshold=d.threshold,
            refuse_at=float(np.log(rules.fnir / (1.0 - rules.fpir))), reason=d.reason,
            ranking=d.ranking, looks=self.looked, evidence=tuple(self.evidence),
            person=self.person, visits=self.visits,
        )  # fmt: skip

    def closeup(self, pipeline: FacePipeline) -> Trace:
        """What the last frames show together of this face, up to its assessment."""
        image = together(self._recent, self.nose_tip)
        denoised = pipeline.denoise(image)
        faces = follow(denoised, self.pose, reference=pipeline.reference)
        trace = Trace(image, denoised, faces, reason=faces.reason)
        if not faces:
            return trace
        alignment = pipeline.register(faces[0])
        trace = replace(trace, face=faces[0], alignment=alignment, reason=alignment.reason)
        if not alignment.converged:
            return trace
        frontal = pipeline.frontal(faces[0], alignment)
        assessment = pipeline.assess(faces[0], alignment, frontal)
        return replace(trace, frontal=frontal, assessment=assessment)

    def _template(self, recognizer: FaceRecognizer) -> Look:
        pipeline = recognizer.pipeline
        trace = self.closeup(pipeline)
        if trace.frontal is None or trace.assessment is None:
            return Look(self.seen_s, None, trace.reason)
        if not trace.assessment.usable:
            return Look(self.seen_s, None, trace.assessment.refusals[0])
        return Look(self.seen_s, pipeline.template_of([trace.frontal], trace.assessment))


def _point(place: Float64) -> Point:
    x, y, z = (round(float(c), 1) for c in place)
    return x, y, z
