"""The way of a face as one frozen value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import DegenerateError, NoFaceError, ParameterError
from rangeface.io.reference import default_reference
from rangeface.register.bootstrap import MIN_FACES, bootstrap
from rangeface.segment import follow
from rangeface.types import (
    Assessment,
    Decision,
    Float32,
    RangeImage,
    ReferenceFace,
    Template,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rangeface.gallery import View


from rangeface.pipeline._augment import noisier, turned
from rangeface.pipeline._compare import capped, compared
from rangeface.pipeline._fingerprint import fingerprint
from rangeface.pipeline._head import Head
from rangeface.pipeline._step import Step
from rangeface.pipeline._trace import Trace, timed


@dataclass(frozen=True, eq=False)
class FacePipeline:
    """The way of a face, its slots in the order of the way.

    What stands before `heads` runs once, however many features are fused. An ablation is
    `dataclasses.replace`; `fit` returns a new, fitted pipeline.

    Parameters
    ----------
    combine : Step
        Frames → one image.
    denoise : Step
        Image → image.
    segment : Step
        Image → Faces.
    register : Step
        Face → Alignment.
    frontal : Step
        (Face, Alignment) → frontal image: the one resampling.
    assess : Step
        (Face, Alignment, frontal image) → Assessment.
    heads : tuple of Head
        At least one.
    normalise : Step
        (Scores (heads, people), scores (heads, cohort)) → scores on one scale (heads, people).
    fuse : Step
        Scores (heads, people) → scores (people,).
    decide : Step
        (scores, subjects, Assessment, threshold) → Decision.
    adapt_reference : bool
        Learn the reference face from the training captures, then register again with it.
    augment_deg : tuple of float
        Each training and enrolment face is also seen rotated by these angles about each of
        the three axes (the paper's twelve additional images).
    augment_noise : tuple of float
        Each training and enrolment face is also seen with these multiples of its sensor's σ
        added: 3 makes about one frame of a mean of ten.

    Raises
    ------
    ParameterError
        There is no head, or `augment_noise` is negative.
    """

    combine: Step
    denoise: Step
    segment: Step
    register: Step
    frontal: Step
    assess: Step
    heads: tuple[Head, ...]
    normalise: Step
    fuse: Step
    decide: Step
    adapt_reference: bool = False
    augment_deg: tuple[float, ...] = (-5.0, -2.5, 2.5, 5.0)
    augment_noise: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.heads:
            raise ParameterError("heads: a pipeline needs at least one (describe, classify)")
        if any(not 0.0 <= multiple < np.inf for multiple in self.augment_noise):
            raise ParameterError(f"augment_noise: must be ≥ 0, got {self.augment_noise}")

    # ── one image ────────────────────────────────────────────────────────────────────────

    def trace(self, image: RangeImage | Sequence[RangeImage]) -> Trace:
        """Follow the most confident face of an image, or of a sequence of frames.

        Parameters
        ----------
        image : RangeImage or sequence of RangeImage
            A sequence is combined first.

        Returns
        -------
        Trace
            Never raises for what the image shows: `reason` says where the way ended.
        """
        return next(self._traces(image))

    def traces(self, image: RangeImage | Sequence[RangeImage]) -> list[Trace]:
        """Follow every face of an image, most confident first.

        Parameters
        ----------
        image : RangeImage or sequence of RangeImage
            A sequence is combined first.

        Returns
        -------
        list of Trace
            One a face; one with a reason if there is no face.
        """
        return list(self._traces(image))

    def _traces(self, image: RangeImage | Sequence[RangeImage]) -> Iterator[Trace]:
        times: dict[str, float] = {}
        if not isinstance(image, RangeImage):
            with timed(times, "combine"):
                image = self.combine(image)
        with timed(times, "denoise"):
            denoised = self.denoise(image)
        with timed(times, "segment"):
            faces = self.segment(denoised)
        assert isinstance(image, RangeImage)
        start = Trace(image, denoised, faces, reason=faces.reason, times_ms=times)
        if not faces:
            yield start
        for face in faces:
            yield self._follow(replace(start, face=face, times_ms=dict(times)))

    def follow(self, image: RangeImage, trace: Trace) -> Trace:
        """Follow a face into the next frame, from where the last one's trace left it.

        Parameters
        ----------
        image : RangeImage
            The next frame.
        trace : Trace
            Of the last frame; if no face was registered there, this one is searched anew.

        Returns
        -------
        Trace
            Its reason is "face lost" where the face has gone.
        """
        if trace.alignment is None or not trace.alignment.converged:
            return self.trace(image)
        times: dict[str, float] = {}
        with timed(times, "denoise"):
            denoised = self.denoise(image)
        with timed(times, "segment"):
            radius_mm = self.segment.all_params().get("radius_mm", 140.0)
            faces = follow(
                denoised, trace.alignment.transform, reference=self.reference, radius_mm=radius_mm
            )
        start = Trace(image, denoised, faces, reason=faces.reason, times_ms=times)
        return self._follow(replace(start, face=faces[0])) if faces else start

    def _follow(self, trace: Trace) -> Trace:
        """From a face to its features."""
        face, times = trace.face, trace.times_ms
        with timed(times, "register"):
            alignment = self.register(face)
        trace = replace(trace, alignment=alignment, reason=alignment.reason)
        if not alignment.converged:
            return trace
        with timed(times, "frontal"):
            frontal = self.frontal(face, alignment)
        with timed(times, "assess"):
            assessment = self.assess(face, alignment, frontal)
        with timed(times, "describe"):
            features = tuple(head.features([frontal]).ravel() for head in self.heads)
        return replace(trace, frontal=frontal, assessment=assessment, features=features)

    def views(self, trace: Trace) -> list[RangeImage]:
        """The frontal image of a traced face, and those that the augmentation adds.

        Parameters
        ----------
        trace : Trace
            That reached the frontal grid.

        Returns
        -------
        list of RangeImage
            1 + 3 · len(augment_deg) + len(augment_noise) images.

        Raises
        ------
        NoFaceError
            The trace ended before.
        """
        if trace.face is None or trace.alignment is None or trace.frontal is None:
            raise NoFaceError(f"no face to learn from: {trace.reason}")
        way = trace.face, trace.alignment, self.frontal
        return [
            trace.frontal, *turned(*way, self.augment_deg), *noisier(*way, self.augment_noise)
        ]  # fmt: skip

    # ── the reference face ───────────────────────────────────────────────────────────────

    @property
    def reference(self) -> ReferenceFace:
        """The reference face that registration aligns to."""
        bound = dict(self.register.params).get("reference")
        return default_reference() if bound is None else bound

    def with_reference(self, reference: ReferenceFace) -> FacePipeline:
        """The same pipeline with another reference face in every step that takes one."""
        slots = {
            slot: bound.with_params(reference=reference)
            for slot in ("segment", "register", "frontal")
            if "reference" in (bound := getattr(self, slot)).all_params()
        }
        return replace(self, **slots)

    def adapted(self, traces: Sequence[Trace]) -> FacePipeline:
        """The pipeline with a reference learned from its own traces, if `adapt_reference` is set.

        Parameters
        ----------
        traces : sequence of Trace
            Of the captures to learn from; those turned by more than 25° do not count.

        Returns
        -------
        FacePipeline
            Unchanged where there are fewer than `bootstrap.MIN_FACES` faces.
        """
        frontals = [
            t.frontal
            for t in traces
            if t.frontal is not None and t.assessment is not None and abs(t.assessment.yaw_deg) < 25
        ]
        if not self.adapt_reference or len(frontals) < MIN_FACES:
            return self
        return self.with_reference(bootstrap(frontals, self.reference))

    # ── learning ─────────────────────────────────────────────────────────────────────────

    def fit(
        self, images: Sequence[RangeImage | Sequence[RangeImage]], subjects: Sequence[str]
    ) -> FacePipeline:
        """Learn every head's classifier from images of known people.

        Parameters
        ----------
        images : sequence of RangeImage or of sequences of frames
            At least two people.
        subjects : sequence of str
            Who each image shows.

        Returns
        -------
        FacePipeline
            A new, fitted pipeline; this one is unchanged.

        Raises
        ------
        NoFaceError
            An image shows no face; the message gives its number and the reason.
        ParameterError
            The numbers of images and subjects differ.
        """
        adapted = self.adapted([self.trace(image) for image in images])
        views = []
        for k, image in enumerate(images):
            trace = adapted.trace(image)
            if trace.frontal is None:
                raise NoFaceError(f"training image {k}: {trace.reason}")
            views.append(adapted.views(trace))
        return adapted.fit_views(views, subjects)

    def fit_views(
        self, views: Sequence[Sequence[RangeImage]], subjects: Sequence[str]
    ) -> FacePipeline:
        """Learn from frontal images: for every capture its views, as `views` gives them.

        Parameters
        ----------
        views : sequence of sequences of RangeImage
            Frontal images, one inner sequence a capture.
        subjects : sequence of str
            Who each capture shows.

        Returns
        -------
        FacePipeline
            A new, fitted pipeline.

        Raises
        ------
        ParameterError
            The numbers of captures and subjects differ.
        DegenerateError
            There is nothing to learn from.
        """
        if len(views) != len(subjects):
            raise ParameterError(f"subjects: {len(subjects)} for {len(views)} captures")
        if not views:
            raise DegenerateError("fit: no capture to learn from")
        flat = [view for capture in views for view in capture]
        labels = [s for capture, s in zip(views, subjects, strict=True) for _ in capture]
        return replace(self, heads=tuple(head.fit(flat, labels) for head in self.heads))

    # ── templates and scores ─────────────────────────────────────────────────────────────

    def template(
        self, image: RangeImage | Sequence[RangeImage] | Trace, *, augment: bool = False
    ) -> Template:
        """Make the template of a face.

        Parameters
        ----------
        image : RangeImage, sequence of RangeImage, or Trace
            What to make it from.
        augment : bool
            Add the rotated views (for enrolment).

        Returns
        -------
        Template

        Raises
        ------
        NoFaceError
            There is no face, or its registration was refused; the message says why.
        """
        trace = image if isinstance(image, Trace) else self.trace(image)
        if trace.frontal is None:
            raise NoFaceError(f"no template: {trace.reason}")
        views = self.views(trace) if augment else [trace.frontal]
        return self.template_of(views, trace.assessment)

    def template_of(
        self, views: Sequence[RangeImage], assessment: Assessment | None = None
    ) -> Template:
        """Make a template from frontal images of one face: one row a view in every head."""
        return Template(
            vectors=tuple(head.rows(views) for head in self.heads),
            fingerprint=self.fingerprint,
            assessment=assessment,
        )

    def decide_on(
        self, scores: Mapping[str, float], assessment: Assessment | None, threshold: float
    ) -> Decision:
        """The decision on scores by subject; `threshold` is the score that is needed."""
        subjects = list(scores)
        values = [scores[subject] for subject in subjects]
        decision: Decision = self.decide(values, subjects, assessment, threshold=threshold)
        return decision

    def head_scores(self, probe: Template, references: View) -> Float32:
        """Every head's own scores of a probe against people: of each, the best pair of views.

        Parameters
        ----------
        probe : Template
        references : View
            Templates of this pipeline by subject: `gallery.view()`, or `gallery.stack`.

        Returns
        -------
        (H, S) float32
            Each head on its own scale, higher = more alike; NaN where it could not compare.

        Raises
        ------
        ParameterError
            A template was made by another pipeline.
        """
        return self._compared(probe, references)[0]

    def _compared(self, probe: Template, references: View) -> tuple[Float32, NDArray[np.bool_]]:
        count = len(references.subjects)
        for made_by in (probe.fingerprint, references.fingerprint if count else None):
            if made_by not in (None, self.fingerprint):
                raise ParameterError(
                    f"template of pipeline {made_by[:12]} does not compare with "
                    f"{self.fingerprint[:12]}: enrol again, or use the model that made it"
                )
        if count == 0:
            return np.empty((len(self.heads), 0), np.float32), np.empty(0, bool)
        return compared(self.heads, probe, references, self.normalise)

    def similarity(
        self, probe: Template, references: View, *, cohort: View | None = None
    ) -> Float32:
        """Fused scores of a probe against people: heads normalised one by one, then fused.

        Parameters
        ----------
        probe : Template
        references : View
            As for `head_scores`.
        cohort : View, optional
            Faces of people who are nobody here, which give every head's scores their scale.

        Returns
        -------
        (S,) float32
            One score a subject; higher = more alike. NaN where no head could compare. Heads
            that work pair by pair see a shortlist; nobody beyond it beats anybody on it.

        Raises
        ------
        ParameterError
            A template was made by another pipeline.
        DegenerateError
            Neither cohort nor gallery gives the scores a scale, and `normalise` needs one.
        """
        scores, listed = self._compared(probe, references)
        if scores.shape[1] == 0:
            return np.empty(0, np.float32)
        others = None if cohort is None else self.head_scores(probe, cohort)
        fused = np.asarray(self.fuse(self.normalise(scores, others)), dtype=np.float32)
        return capped(fused, listed)

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 over steps, parameters, revisions and learned arrays: 64 hex digits.

        Two pipelines with the same fingerprint make templates that compare. A library's
        version is not part of it.
        """
        return fingerprint(self)
