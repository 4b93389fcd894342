"""Steps, heads and the pipeline: the way of a face as one frozen value."""

from __future__ import annotations

import hashlib
import inspect
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rangeface.classify import fitted_state
from rangeface.decide import per_subject
from rangeface.errors import DegenerateError, NoFaceError, ParameterError
from rangeface.io.reference import default_reference
from rangeface.numerics.se3 import rotation_matrix
from rangeface.register.bootstrap import MIN_FACES, bootstrap
from rangeface.types import (
    Alignment,
    Assessment,
    Decision,
    Face,
    Faces,
    Float32,
    RangeImage,
    Reason,
    ReferenceFace,
    RigidTransform,
    Template,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rangeface.classify import Matcher
    from rangeface.gallery import View


@dataclass(frozen=True)
class Step:
    """A method with its parameters bound: comparable, hashable, picklable.

    Build one with `step`, which checks the parameters.

    Parameters
    ----------
    method : callable
        A public function of a stage.
    params : tuple of (str, value)
        Keyword parameters, sorted by name.
    """

    method: Callable[..., Any]
    params: tuple[tuple[str, Any], ...] = ()

    def __call__(self, *args: Any, **late: Any) -> Any:
        """Call the method; `late` are parameters known only at run time."""
        return self.method(*args, **dict(self.params), **late)

    @property
    def name(self) -> str:
        """Name of the method."""
        return self.method.__name__

    def all_params(self) -> dict[str, Any]:
        """Every keyword parameter with its value, defaults and the default reference included."""
        bound = dict(self.params)
        for name, parameter in inspect.signature(self.method).parameters.items():
            if parameter.kind is inspect.Parameter.KEYWORD_ONLY:
                bound.setdefault(name, parameter.default)
        if "reference" in bound and bound["reference"] is None:
            bound["reference"] = default_reference()
        return bound

    def with_params(self, **params: Any) -> Step:
        """The same method with some parameters changed."""
        return step(self.method, **{**dict(self.params), **params})

    def __repr__(self) -> str:
        inner = ", ".join(f"{k}={v!r}" for k, v in self.params)
        return f"{self.name}({inner})"


def step(method: Callable[..., Any], /, **params: Any) -> Step:
    """Bind keyword parameters to a method; a wrong one fails here, on its own line.

    Parameters
    ----------
    method : callable
        A public function of a stage: ``f(image, *, …)``.
    **params
        Keyword parameters of it.

    Returns
    -------
    Step

    Raises
    ------
    ParameterError
        The method has no such keyword parameter; the message lists those it has.

    Examples
    --------
    >>> from rangeface import denoise
    >>> step(denoise.median, size_px=5)
    median(size_px=5)
    """
    known = {
        name
        for name, parameter in inspect.signature(method).parameters.items()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    }
    for name in params:
        if name not in known:
            takes = ", ".join(sorted(known))
            raise ParameterError(f"{method.__name__}: unknown parameter {name!r}; it takes {takes}")
    return Step(method, tuple(sorted((k, _hashable(v)) for k, v in params.items())))


def _hashable(value: Any) -> Any:
    return tuple(_hashable(v) for v in value) if isinstance(value, list | tuple) else value


@dataclass(frozen=True, eq=False)
class Head:
    """A feature and the classifier that learns from it.

    Parameters
    ----------
    describe : Step
        Frontal image → array.
    classify : Matcher
        Estimator of `rangeface.classify`, fitted or not.
    """

    describe: Step
    classify: Matcher

    def features(self, views: Sequence[RangeImage]) -> Float32:
        """One row (n, D) for every frontal image."""
        return np.stack([np.ravel(self.describe(view)) for view in views]).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Trace:
    """Every intermediate of one image's way, and what each stage took.

    Parameters
    ----------
    image : RangeImage
        The (combined) image.
    denoised : RangeImage
        After denoising.
    faces : Faces
        All faces found, most confident first.
    face : Face, optional
        The one that is followed.
    alignment, frontal, assessment
        Of that face; None where the way ended before.
    features : tuple of arrays
        One a head.
    reason : Reason, optional
        Why the way ended.
    times_ms : mapping of str to float
        Stage → milliseconds.
    """

    image: RangeImage
    denoised: RangeImage
    faces: Faces
    face: Face | None = None
    alignment: Alignment | None = None
    frontal: RangeImage | None = None
    assessment: Assessment | None = None
    features: tuple[Float32, ...] = ()
    reason: Reason | None = None
    times_ms: dict[str, float] = field(default_factory=dict)


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
    fuse : Step
        Scores (heads, m) → scores (m,).
    decide : Step
        (scores, subjects, Assessment, threshold) → Decision.
    adapt_reference : bool
        Learn the reference face from the training captures, then register again with it.
    augment_deg : tuple of float
        Each training and enrolment face is also seen rotated by these angles about each of
        the three axes (the paper's twelve additional images).

    Raises
    ------
    ParameterError
        There is no head.
    """

    combine: Step
    denoise: Step
    segment: Step
    register: Step
    frontal: Step
    assess: Step
    heads: tuple[Head, ...]
    fuse: Step
    decide: Step
    adapt_reference: bool = False
    augment_deg: tuple[float, ...] = (-5.0, -2.5, 2.5, 5.0)

    def __post_init__(self) -> None:
        if not self.heads:
            raise ParameterError("heads: a pipeline needs at least one (describe, classify)")

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
            with _timed(times, "combine"):
                image = self.combine(image)
        with _timed(times, "denoise"):
            denoised = self.denoise(image)
        with _timed(times, "segment"):
            faces = self.segment(denoised)
        assert isinstance(image, RangeImage)
        start = Trace(image, denoised, faces, reason=faces.reason, times_ms=times)
        if not faces:
            yield start
        for face in faces:
            yield self._follow(replace(start, face=face, times_ms=dict(times)))

    def _follow(self, trace: Trace) -> Trace:
        """From a face to its features."""
        face, times = trace.face, trace.times_ms
        with _timed(times, "register"):
            alignment = self.register(face)
        trace = replace(trace, alignment=alignment, reason=alignment.reason)
        if not alignment.converged:
            return trace
        with _timed(times, "frontal"):
            frontal = self.frontal(face, alignment)
        with _timed(times, "assess"):
            assessment = self.assess(face, alignment, frontal)
        with _timed(times, "describe"):
            features = tuple(head.features([frontal])[0] for head in self.heads)
        return replace(trace, frontal=frontal, assessment=assessment, features=features)

    def views(self, trace: Trace) -> list[RangeImage]:
        """The frontal image of a traced face, and those of the augmented rotations.

        Parameters
        ----------
        trace : Trace
            That reached the frontal grid.

        Returns
        -------
        list of RangeImage
            1 + 3 · len(augment_deg) images.

        Raises
        ------
        NoFaceError
            The trace ended before.
        """
        if trace.face is None or trace.alignment is None or trace.frontal is None:
            raise NoFaceError(f"no face to learn from: {trace.reason}")
        turned = [trace.frontal]
        for axis in np.eye(3):
            for angle in self.augment_deg:
                turn = RigidTransform(
                    rotation_matrix(np.deg2rad(angle) * axis), np.zeros(3), source="face"
                )
                alignment = replace(trace.alignment, transform=turn @ trace.alignment.transform)
                turned.append(self.frontal(trace.face, alignment))
        return turned

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
        labels = np.repeat(np.asarray(subjects, dtype=str), [len(capture) for capture in views])
        heads = []
        for head in self.heads:
            estimator = type(head.classify)(**head.classify.get_params())
            heads.append(replace(head, classify=estimator.fit(head.features(flat), labels)))
        return replace(self, heads=tuple(heads))

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
            vectors=tuple(head.classify.transform(head.features(views)) for head in self.heads),
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

    def similarity(self, probe: Template, references: View) -> Float32:
        """Fused scores of a probe against people: of each, the best pair of views.

        Parameters
        ----------
        probe : Template
        references : View
            Templates of this pipeline by subject: `gallery.view()`, or `gallery.stack`.

        Returns
        -------
        (S,) float32
            One score a subject; higher = more alike.

        Raises
        ------
        ParameterError
            A template was made by another pipeline.
        """
        count = len(references.subjects)
        for fingerprint in (probe.fingerprint, references.fingerprint if count else None):
            if fingerprint not in (None, self.fingerprint):
                raise ParameterError(
                    f"template of pipeline {fingerprint[:12]} does not compare with "
                    f"{self.fingerprint[:12]}: enrol again, or use the model that made it"
                )
        if count == 0:
            return np.empty(0, np.float32)
        per_head = [
            per_subject(head.classify.similarity(p, g).max(axis=0), owners, count=count)
            for head, p, g, owners in zip(
                self.heads, probe.vectors, references.vectors, references.owners, strict=True
            )
        ]
        return np.asarray(self.fuse(np.stack(per_head)), dtype=np.float32)

    @property
    def fingerprint(self) -> str:
        """SHA-256 over steps, parameters, revisions and learned arrays: 64 hex digits.

        Two pipelines with the same fingerprint make templates that compare. A library's
        version is not part of it.
        """
        cached = self.__dict__.get("_fingerprint")
        if cached is None:
            digest = hashlib.sha256()
            for part in _parts(self):
                digest.update(part)
            cached = digest.hexdigest()
            object.__setattr__(self, "_fingerprint", cached)
        return str(cached)


@contextmanager
def _timed(times_ms: dict[str, float], stage: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    times_ms[stage] = 1e3 * (time.perf_counter() - start)


def _parts(value: Any) -> Iterator[bytes]:
    """The bytes that a value's identity depends on, prefix-free."""
    if isinstance(value, Step):
        number = getattr(value.method, "revision", 1)
        yield f"step {value.method.__module__}.{value.name} r{number};".encode()
        yield from _parts(value.all_params())
    elif isinstance(value, Head):
        estimator = value.classify
        yield from _parts(value.describe)
        yield f"head {type(estimator).__name__} r{getattr(estimator, 'revision', 1)};".encode()
        yield from _parts(estimator.get_params())
        yield from _parts(fitted_state(estimator))
    elif isinstance(value, np.ndarray):
        yield f"array {value.dtype.str} {value.shape};".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif is_dataclass(value) and not isinstance(value, type):
        yield f"{type(value).__name__}(".encode()
        for f in fields(value):
            yield f"{f.name}=".encode()
            yield from _parts(getattr(value, f.name))
        yield b")"
    elif hasattr(value, "items"):
        yield f"map {len(value)};".encode()
        for key in sorted(value):
            yield f"{key}:".encode()
            yield from _parts(value[key])
    elif isinstance(value, list | tuple):
        yield f"list {len(value)};".encode()
        for item in value:
            yield from _parts(item)
    else:
        yield f"{type(value).__name__} {value!r};".encode()
