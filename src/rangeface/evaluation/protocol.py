"""Run a protocol: learn, enrol the gallery, score every probe."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from rangeface.errors import DegenerateError, NoFaceError
from rangeface.evaluation.captures import Capture, Views, acquire, stage_times
from rangeface.evaluation.scores import Rates, Scores, rates
from rangeface.gallery import View, stack
from rangeface.pipeline import FacePipeline, Trace
from rangeface.recognizer import FaceRecognizer, with_shipped_heads
from rangeface.types import Float64, Template

__all__ = [
    "Capture",
    "Rates",
    "Scores",
    "Views",
    "acquire",
    "compare",
    "rates",
    "score",
    "stage_times",
]


def compare(
    pipeline: FacePipeline,
    captures: Sequence[Capture],
    *,
    training: Sequence[Capture] | None = None,
    views: Views | None = None,
) -> Scores:
    """Fit on the training captures, enrol the gallery, and score every probe.

    Parameters
    ----------
    pipeline : FacePipeline
        Fitted again here.
    captures : sequence of Capture
        Roles "gallery" and "probe" (and "train").
    training : sequence of Capture, optional
        Default: those of role "train"; if there is none, the gallery itself.
    views : dict, optional
        Frontal views that a run with other heads has already made; filled here.

    Returns
    -------
    Scores
        Normalised against the gallery: there is no cohort.

    Raises
    ------
    NoFaceError
        No training capture or no gallery capture shows a face.
    DegenerateError
        There is no gallery or no probe.
    """
    if training is None:
        training = [c for c in captures if c.scan.role == "train"]
        training = training or [c for c in captures if c.scan.role == "gallery"]
    usable = [c for c in training if c.acquired]
    if not usable:
        raise NoFaceError(f"no face in any of {len(training)} training scans")
    views = {} if views is None else views
    _add_views(views, pipeline, usable)
    pipeline = with_shipped_heads(pipeline)
    fitted = pipeline.fit_views([views[c] for c in usable], [c.scan.subject for c in usable])
    return score(FaceRecognizer(fitted), captures, views=views)


def score(
    recognizer: FaceRecognizer, captures: Sequence[Capture], *, views: Views | None = None
) -> Scores:
    """Enrol the gallery with a model and score every probe; nothing is learned here.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Its pipeline made the captures' traces.
    captures : sequence of Capture
        Roles "gallery" and "probe".
    views : dict, optional
        As for `compare`.

    Returns
    -------
    Scores

    Raises
    ------
    NoFaceError
        No gallery capture shows a face.
    DegenerateError
        There is no gallery or no probe.
    """
    gallery = [c for c in captures if c.scan.role == "gallery"]
    probes = tuple(c for c in captures if c.scan.role == "probe")
    if not gallery or not probes:
        raise DegenerateError(
            f"{len(gallery)} gallery scans and {len(probes)} probes: both are needed"
        )
    enrolled = [c for c in gallery if c.acquired]
    if not enrolled:
        raise NoFaceError(f"no face in any of {len(gallery)} gallery scans")
    views = {} if views is None else views
    way = recognizer.pipeline
    _add_views(views, way, enrolled)
    references = stack(
        ((c.scan.subject, way.template_of(views[c])) for c in enrolled), way.fingerprint
    )
    people = tuple(sorted({c.scan.subject for c in gallery}))
    column = [people.index(subject) for subject in references.subjects]
    heads = np.full((len(way.heads), len(probes), len(people)), np.nan)
    raw = heads.copy()
    times = []
    for k, capture in enumerate(probes):
        if capture.acquired:
            start = time.perf_counter()
            probe = way.template(_trace(capture))
            own = way.head_scores(probe, references)
            cohort = recognizer.cohort and way.head_scores(probe, recognizer.cohort)
            raw[:, k, column], heads[:, k, column] = own, way.normalise(own, cohort)
            times.append(1e3 * (time.perf_counter() - start))
    centre, spread = _fixed_scale(
        way, [way.template_of(views[c][:1]) for c in enrolled], references
    )
    fixed = (raw - centre) / spread
    return Scores(
        heads,
        fixed,
        np.asarray(way.fuse(heads), np.float64),
        np.asarray(way.fuse(fixed), np.float64),
        probes,
        people,
        len(references.subjects),
        way.fingerprint,
        float(np.median(times)) if times else float("nan"),
    )


def _fixed_scale(
    way: FacePipeline, templates: Sequence[Template], references: View
) -> tuple[Float64, Float64]:
    """Each head's median and spread (H, 1, 1) over comparisons of different enrolled people."""
    scores = np.stack([way.head_scores(t, references) for t in templates], axis=1)
    best = np.nan_to_num(scores, nan=-np.inf).argmax(axis=2)  # a face is nearest to itself
    np.put_along_axis(scores, best[..., None], np.nan, axis=2)
    flat = scores.reshape(len(scores), -1)
    known = ~np.isnan(flat).all(axis=1)
    centre, spread = np.zeros(len(flat)), np.ones(len(flat))
    centre[known] = np.nanmedian(flat[known], axis=1)
    spread[known] = np.nanmedian(np.abs(flat[known] - centre[known, None]), axis=1)
    return centre[:, None, None], np.where(spread > 0, spread, 1.0)[:, None, None]


def _add_views(views: Views, pipeline: FacePipeline, captures: Sequence[Capture]) -> None:
    for capture in captures:
        if capture not in views:
            views[capture] = pipeline.views(_trace(capture))


def _trace(capture: Capture) -> Trace:
    assert capture.trace is not None
    return capture.trace
