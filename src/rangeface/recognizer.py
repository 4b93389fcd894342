"""FaceRecognizer: a fitted pipeline, what its scores mean, and where it comes from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np

from rangeface import classify, config
from rangeface.decide import refuse, threshold_at_fmr, verify
from rangeface.errors import (
    DegenerateError,
    GalleryError,
    NoFaceError,
    ParameterError,
    ScanError,
    ScanFault,
)
from rangeface.gallery import Gallery, View, stack
from rangeface.io.arrays import read_arrays, write_arrays
from rangeface.io.reference import reference_from, reference_header
from rangeface.pipeline import FacePipeline, Head, Trace
from rangeface.types import Decision, Float32, RangeImage, Reason, Template

Frames = RangeImage | Sequence[RangeImage]

#: People in a cohort: enough for a median and its deviation, few enough for every probe to meet.
_COHORT = 60
_SHIPPED = "default.model"


@dataclass(frozen=True, eq=False)
class FaceRecognizer:
    """Recognises people: a fitted pipeline, a cohort that gives scores a scale, thresholds.

    Parameters
    ----------
    pipeline : FacePipeline
        Fitted.
    cohort : View, optional
        Faces of people who are nobody here. Every head's score is expressed as its distance
        from what the probe reaches against them and against the others in the gallery, so that
        heads can be added and one threshold serves every probe.
    nonmated : (k,) float32
        Normalised scores of different people, from calibration: thresholds are read from them.
    provenance : mapping
        What it was learned from, with which versions; JSON.
    """

    pipeline: FacePipeline
    cohort: View | None = None
    nonmated: Float32 = field(default_factory=lambda: np.empty(0, np.float32))
    provenance: Mapping[str, Any] = field(default_factory=dict)

    # ── learning ─────────────────────────────────────────────────────────────────────────

    @classmethod
    def fit(
        cls,
        pipeline: FacePipeline,
        images: Sequence[Frames],
        subjects: Sequence[str],
        *,
        provenance: Mapping[str, Any] | None = None,
    ) -> FaceRecognizer:
        """Learn a pipeline from images of known people; they become the cohort.

        Parameters
        ----------
        pipeline : FacePipeline
            Not fitted.
        images : sequence of RangeImage or of sequences of frames
        subjects : sequence of str
        provenance : mapping, optional
            JSON.

        Returns
        -------
        FaceRecognizer
            Not calibrated yet.

        Raises
        ------
        NoFaceError
            No image shows a face. Single failures are left out and counted in `provenance`.
        ParameterError
            The numbers of images and subjects differ.
        """
        if len(images) != len(subjects):
            raise ParameterError(f"subjects: {len(subjects)} for {len(images)} images")
        adapted = pipeline.adapted([pipeline.trace(image) for image in images])
        traces = [adapted.trace(image) for image in images]
        return cls.fit_traces(adapted, traces, subjects, provenance=provenance)

    @classmethod
    def fit_traces(
        cls,
        pipeline: FacePipeline,
        traces: Sequence[Trace],
        subjects: Sequence[str],
        *,
        provenance: Mapping[str, Any] | None = None,
    ) -> FaceRecognizer:
        """Learn from traces that the same (unfitted, adapted) pipeline made; else as `fit`."""
        usable = [(t, s) for t, s in zip(traces, subjects, strict=True) if t.frontal is not None]
        if not usable:
            raise NoFaceError(f"none of {len(traces)} training images shows a face")
        pipeline = with_shipped_heads(pipeline)
        fitted = pipeline.fit_views([pipeline.views(t) for t, _ in usable], [s for _, s in usable])
        first = {subject: trace for trace, subject in reversed(usable)}
        some = sorted(first)[:_COHORT]
        cohort = stack(((s, fitted.template(first[s])) for s in some), fitted.fingerprint)
        story = {
            **(provenance or {}),
            "people": len(first),
            "images": len(usable),
            "failed_to_enrol": len(traces) - len(usable),
        }
        return cls(fitted, cohort, provenance=story)

    def calibrate(self, templates: Sequence[Template], subjects: Sequence[str]) -> FaceRecognizer:
        """Learn what scores different people reach, from people who were not trained on.

        Parameters
        ----------
        templates : sequence of Template
            Of this pipeline; at least two people.
        subjects : sequence of str

        Returns
        -------
        FaceRecognizer
            With `nonmated` filled, and with these people as its cohort: they stood before the
            sensor that will be used. Templates that were enrolled before stay valid.

        Raises
        ------
        DegenerateError
            There is only one person.
        """
        if len(set(subjects)) < 2:
            raise DegenerateError("calibrate: at least two different people are needed")
        references = stack(zip(subjects, templates, strict=True), self.pipeline.fingerprint)
        first = dict(reversed(list(zip(subjects, templates, strict=True))))
        some = sorted(first)[:_COHORT]
        cohort = stack(((s, first[s]) for s in some), self.pipeline.fingerprint)
        calibrated = replace(self, cohort=cohort)
        scores = np.stack([calibrated.scores(probe, references) for probe in templates])
        different = np.asarray(subjects)[:, None] != np.asarray(references.subjects)[None, :]
        nonmated = scores[different & ~np.isnan(scores)]
        return replace(calibrated, nonmated=np.sort(nonmated).astype(np.float32))

    # ── use ──────────────────────────────────────────────────────────────────────────────

    def template(self, image: Frames | Trace, *, augment: bool = False) -> Template:
        """Make a template; see `FacePipeline.template`."""
        return self.pipeline.template(image, augment=augment)

    def scores(self, probe: Template, references: View) -> Float32:
        """Normalised scores (S,) of a probe, one a subject: higher = more alike.

        Parameters
        ----------
        probe : Template
        references : View

        Returns
        -------
        (S,) float32
        """
        return self.pipeline.similarity(probe, references, cohort=self.cohort)

    def threshold(self, fmr: float) -> float:
        """Score that different people reach with probability `fmr`.

        Parameters
        ----------
        fmr : float
            False match rate of one comparison, at least 3 / number of calibration pairs.

        Returns
        -------
        float

        Raises
        ------
        ParameterError
            The recogniser is not calibrated, or too few pairs can show so small a rate.
        """
        if self.nonmated.size == 0:
            raise ParameterError("fmr: this model is not calibrated; run `rangeface calibrate`")
        return threshold_at_fmr(self.nonmated, fmr)

    def verify(
        self, image: Frames | Trace, subject: str, gallery: Gallery, *, fmr: float = 0.001
    ) -> Decision:
        """Is this the person it claims to be?

        Parameters
        ----------
        image : RangeImage, sequence of RangeImage, or Trace
        subject : str
            Who it claims to be.
        gallery : Gallery
        fmr : float
            Accepted false match rate of one comparison.

        Returns
        -------
        Decision

        Raises
        ------
        GalleryError
            The subject is not enrolled, or the gallery belongs to another model.
        """
        threshold = self.threshold(fmr)
        view = gallery.view()
        if subject not in view.subjects:
            raise GalleryError(f"{subject!r} is not enrolled; `rangeface list` shows who is")
        trace = image if isinstance(image, Trace) else self.pipeline.trace(image)
        if trace.frontal is None:
            return refuse(trace.reason or Reason.NO_FACE, threshold=threshold)
        probe = self.template(trace)
        score = self.scores(probe, view)[view.subjects.index(subject)]
        return verify(float(score), subject, probe.assessment, threshold=threshold)

    def identify(self, image: Frames | Trace, gallery: Gallery, *, fmr: float = 0.001) -> Decision:
        """Who is this, of those who are enrolled?

        Parameters
        ----------
        image : RangeImage, sequence of RangeImage, or Trace
        gallery : Gallery
        fmr : float
            Accepted false match rate of one comparison; with N people enrolled a stranger is
            accepted with about N times this probability.

        Returns
        -------
        Decision
            *unknown* for a stranger, *cannot tell* where the image does not suffice.
        """
        threshold = self.threshold(fmr)
        trace = image if isinstance(image, Trace) else self.pipeline.trace(image)
        if trace.frontal is None:
            return refuse(trace.reason or Reason.NO_FACE, threshold=threshold)
        probe = self.template(trace)
        view = gallery.view()
        scores = self.scores(probe, view)
        return self.pipeline.decide_on(
            dict(zip(view.subjects, scores.tolist(), strict=True)), probe.assessment, threshold
        )

    # ── files ────────────────────────────────────────────────────────────────────────────

    def save(self, path: str | Path) -> None:
        """Write the recogniser to a file: JSON header and raw arrays with hashes, no pickle.

        Parameters
        ----------
        path : str or Path
        """
        arrays: dict[str, np.ndarray] = {"nonmated": self.nonmated}
        heads = []
        for h, head in enumerate(self.pipeline.heads):
            state = classify.fitted_state(head.classify)
            arrays |= {f"head{h}.{k}": v for k, v in state.items() if isinstance(v, np.ndarray)}
            heads.append({k: v for k, v in state.items() if not isinstance(v, np.ndarray)})
            if self.cohort is not None:
                arrays[f"cohort{h}"] = self.cohort.vectors[h]
                arrays[f"cohort{h}.owners"] = self.cohort.owners[h].astype(np.int32)
        reference = self.pipeline.reference
        arrays["reference.depth"] = reference.image.depth
        if reference.image.sigma is not None:
            arrays["reference.sigma"] = reference.image.sigma
        meta = {
            "reference": reference_header(reference),
            "pipeline": config.to_toml(self.pipeline),
            "fingerprint": self.pipeline.fingerprint,
            "heads": heads,
            "cohort": 0 if self.cohort is None else len(self.cohort.subjects),
            "provenance": dict(self.provenance),
        }
        write_arrays(Path(path), meta, arrays)

    @classmethod
    def load(cls, path: str | Path) -> FaceRecognizer:
        """Read a recogniser that `save` wrote.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        FaceRecognizer

        Raises
        ------
        ScanError
            The file is missing, damaged, of another kind, or of another version of the methods.
        """
        meta, arrays = read_arrays(Path(path))
        try:
            pipeline = config.from_toml(meta["pipeline"]).with_reference(
                reference_from(
                    meta["reference"], arrays["reference.depth"], arrays.get("reference.sigma")
                )
            )
            heads = tuple(
                _restored(head, h, meta["heads"][h], arrays)
                for h, head in enumerate(pipeline.heads)
            )
            pipeline = replace(pipeline, heads=heads)
            fingerprint, provenance = meta["fingerprint"], meta["provenance"]
            cohort = _cohort(meta["cohort"], len(heads), arrays, fingerprint)
        except (KeyError, IndexError, TypeError, ParameterError) as error:
            raise ScanError(path, ScanFault.MALFORMED, f"no recogniser ({error})") from error
        if pipeline.fingerprint != fingerprint:
            raise ScanError(
                path, ScanFault.UNSUPPORTED,
                "the methods' numbers have changed since this model was made; train it again",
            )  # fmt: skip
        return cls(pipeline, cohort, arrays["nonmated"], provenance)


def default_model() -> bytes:
    """The file of the model that ships, as `make reference` trains it."""
    return (files("rangeface") / "data" / _SHIPPED).read_bytes()


@lru_cache(maxsize=1)
def default_recognizer() -> FaceRecognizer:
    """The model that ships, read once.

    Returns
    -------
    FaceRecognizer
    """
    with as_file(files("rangeface") / "data" / _SHIPPED) as path:
        return FaceRecognizer.load(path)


def with_shipped_heads(pipeline: FacePipeline) -> FacePipeline:
    """The pipeline with the classifiers that the shipped model has learned, where heads want them.

    Parameters
    ----------
    pipeline : FacePipeline

    Returns
    -------
    FacePipeline

    Raises
    ------
    ParameterError
        A head is to be a shipped one, and the shipped model has none with this feature and
        classifier, or resamples faces in another way.
    """
    if not any(head.shipped for head in pipeline.heads):
        return pipeline
    known = default_recognizer().pipeline
    if _grid(pipeline) != _grid(known):
        raise ParameterError("heads: the shipped ones need the frontal grid of the preset default")
    return replace(pipeline, heads=tuple(_shipped(head, known) for head in pipeline.heads))


def _grid(pipeline: FacePipeline) -> dict[str, Any]:
    return {k: v for k, v in pipeline.frontal.all_params().items() if k != "reference"}


def _shipped(head: Head, known: FacePipeline) -> Head:
    if not head.shipped:
        return head
    for other in known.heads:
        alike = type(other.classify) is type(head.classify) and other.describe == head.describe
        if alike and other.classify.get_params() == head.classify.get_params():
            return replace(head, classify=other.classify)
    raise ParameterError(f"heads: the model that ships has not learned this {head.describe.name}")


def _cohort(
    people: int, heads: int, arrays: Mapping[str, np.ndarray], fingerprint: str
) -> View | None:
    """The nameless people of a model file."""
    if people == 0:
        return None
    return View(
        subjects=tuple(f"cohort {k}" for k in range(people)),
        owners=tuple(arrays[f"cohort{h}.owners"].astype(np.intp) for h in range(heads)),
        vectors=tuple(arrays[f"cohort{h}"] for h in range(heads)),
        fingerprint=fingerprint,
    )


def _restored(
    head: Head, number: int, scalars: Mapping[str, Any], arrays: Mapping[str, np.ndarray]
) -> Head:
    prefix = f"head{number}."
    state = {k.removeprefix(prefix): v for k, v in arrays.items() if k.startswith(prefix)}
    estimator = classify.restore(
        type(head.classify), head.classify.get_params(), {**state, **scalars}
    )
    return replace(head, classify=estimator)
