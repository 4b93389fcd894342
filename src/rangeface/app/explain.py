"""`rangeface explain`: which parts of the face speak for a person, and which against."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.markup import escape
from rich.table import Table

from rangeface.app.console import console
from rangeface.app.models import load_model
from rangeface.app.people import look
from rangeface.classify import SurfaceMatcher
from rangeface.errors import GalleryError, ParameterError
from rangeface.evaluation.pictures import png, shaded_rgb
from rangeface.gallery import View, open_gallery
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Decision, Float32, Orthographic, RangeImage, Template, Verdict

#: Parts of the face as boxes in the face frame, mm: left, top, right, bottom. x runs to the
#: subject's left, y down, the nose tip is (0, 0).
REGIONS = {
    "forehead": (-45, -95, 45, -58),
    "right eye and brow": (-55, -58, -10, -22),
    "left eye and brow": (10, -58, 55, -22),
    "nose bridge": (-10, -58, 10, -22),
    "nose": (-18, -22, 18, 12),
    "right cheek": (-60, -22, -18, 30),
    "left cheek": (18, -22, 60, 30),
    "mouth": (-30, 12, 30, 48),
    "chin": (-35, 48, 35, 80),
}
#: Fewer compared pixels than this in a region say nothing.
_FEWEST = 10


@dataclass(frozen=True)
class Part:
    """One region of the face, compared with one person.

    Parameters
    ----------
    name : str
    residual_mm : float
        Median distance of the two surfaces there; NaN where they could not be compared.
    others_mm : float
        The same against other people, median.
    evidence : float
        How many of the others' deviations it lies below their median: positive speaks for the
        person.
    """

    name: str
    residual_mm: float
    others_mm: float
    evidence: float


def run(
    files: Sequence[Path],
    gallery: str,
    subject: str | None,
    *,
    fmr: float,
    model: Path | None,
    camera: Path | None,
    out: Path,
) -> None:
    """Print the decision, the heads and the regions; draw the map; exit status as `identify`."""
    recognizer = load_model(model)
    trace = look(recognizer, files, camera)
    with open_gallery(gallery, create=False) as opened:
        if subject is None:
            decision = recognizer.identify(trace, opened, fmr=fmr)
        else:
            decision = recognizer.verify(trace, subject, opened, fmr=fmr)
        view = opened.view()
    _print_decision(decision)
    if trace.frontal is None or not decision.ranking:
        console.print("nothing was compared: there is nothing to explain")
        sys.exit(1)
    person = subject or decision.ranking[0][0]
    probe = recognizer.template(trace)
    _print_heads(recognizer, probe, view, person)
    parts, residuals = compare(recognizer, probe, view, person)
    _print_parts(parts, person)
    out.write_bytes(draw(trace.frontal, enrolled_surface(recognizer, view, person, trace.frontal),
                         residuals, parts, f"{person}: {decision.verdict}"))  # fmt: skip
    console.print(f"{out}", highlight=False, markup=False)
    if decision.verdict is not Verdict.ACCEPTED:
        sys.exit(1)


def compare(
    recognizer: FaceRecognizer, probe: Template, view: View, person: str
) -> tuple[list[Part], Float32]:
    """Regions of a probe against an enrolled person, and the map of residuals (H, W) mm.

    Raises
    ------
    ParameterError
        The model has no head that compares surfaces.
    GalleryError
        The person is not enrolled.
    """
    matcher, own, others = _surfaces(recognizer, view, person)
    head = _surface_head(recognizer)
    p = probe.vectors[head][0]
    maps = [matcher.residuals(p, row) for row in own]
    best = min(maps, key=lambda m: float(np.nanmedian(np.abs(m))) if np.isfinite(m).any() else 1e9)
    reached = [matcher.residuals(p, row) for row in others]
    shape, pitch = best.shape, matcher.pitch_mm
    parts = []
    for name, box in REGIONS.items():
        inside = _inside(box, shape, pitch)
        mine = _median(best, inside)
        theirs = np.array([_median(m, inside) for m in reached])
        theirs = theirs[np.isfinite(theirs)]
        middle, evidence = float("nan"), float("nan")
        if len(theirs) >= 2:
            middle = float(np.median(theirs))
            spread = 1.4826 * float(np.median(np.abs(theirs - middle)))
            evidence = (middle - mine) / max(spread, 0.05)
        parts.append(Part(name, mine, middle, evidence))
    return parts, best


def draw(
    probe: RangeImage,
    enrolled: RangeImage,
    residuals: Float32,
    parts: Sequence[Part],
    title: str,
) -> bytes:
    """Probe, enrolled surface, their distance, and what each region says, as a PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 4)
    for axis, name in zip(axes, ("probe", "enrolled", "distance, mm", "evidence"), strict=True):
        axis.set_title(name, fontsize=9)
        axis.set_axis_off()
    axes[0].imshow(shaded_rgb(probe))
    axes[1].imshow(shaded_rgb(enrolled))
    axes[2].imshow(shaded_rgb(probe), alpha=0.35)
    shown = axes[2].imshow(residuals, cmap="RdBu_r", vmin=-6, vmax=6, alpha=0.85)
    figure.colorbar(shown, ax=axes[2], shrink=0.7)
    axes[3].imshow(shaded_rgb(probe), alpha=0.5)
    assert isinstance(probe.camera, Orthographic)
    layer = np.full(probe.shape, np.nan)
    for part in parts:
        inside = _inside(REGIONS[part.name], probe.shape, probe.camera.pitch_mm)
        layer[inside] = part.evidence
        rows, cols = np.nonzero(inside)
        text = f"{part.evidence:+.1f}" if np.isfinite(part.evidence) else "?"
        axes[3].text(cols.mean(), rows.mean(), text, ha="center", va="center", fontsize=8)
    shown = axes[3].imshow(layer, cmap="RdYlGn", vmin=-3, vmax=3, alpha=0.6)
    figure.colorbar(shown, ax=axes[3], shrink=0.7)
    figure.suptitle(title, fontsize=10)
    return png(figure)


def enrolled_surface(
    recognizer: FaceRecognizer, view: View, person: str, like: RangeImage
) -> RangeImage:
    """The first enrolled surface of a person, on the frontal grid."""
    matcher, own, _ = _surfaces(recognizer, view, person)
    depth, certainty = np.moveaxis(own[0].reshape(-1, matcher.width, 2), -1, 0)
    return RangeImage(np.where(certainty > 0, depth, np.nan), like.camera)


def _surface_head(recognizer: FaceRecognizer) -> int:
    for number, head in enumerate(recognizer.pipeline.heads):
        if isinstance(head.classify, SurfaceMatcher):
            return number
    raise ParameterError("model: explaining needs a head of surfaces, as fusion-3d has")


def _surfaces(
    recognizer: FaceRecognizer, view: View, person: str
) -> tuple[SurfaceMatcher, Float32, Float32]:
    """The matcher, the person's surfaces, and those of others: enrolled, then cohort."""
    head = _surface_head(recognizer)
    if person not in view.subjects:
        raise GalleryError(f"{person!r} is not enrolled; `rangeface list` shows who is")
    mine = view.owners[head] == view.subjects.index(person)
    others = [view.vectors[head][~mine][:60]]
    if recognizer.cohort is not None:
        others.append(recognizer.cohort.vectors[head])
    matcher = recognizer.pipeline.heads[head].classify
    assert isinstance(matcher, SurfaceMatcher)
    return matcher, view.vectors[head][mine], np.concatenate(others)[:60]


def _inside(
    box: tuple[int, int, int, int], shape: tuple[int, ...], pitch_mm: float
) -> NDArray[np.bool_]:
    rows, cols = np.mgrid[: shape[0], : shape[1]]
    x = (cols - 0.5 * (shape[1] - 1)) * pitch_mm
    y = (rows - 0.5 * (shape[0] - 1)) * pitch_mm
    left, top, right, bottom = box
    return np.asarray((x >= left) & (x < right) & (y >= top) & (y < bottom))


def _median(residuals: Float32, inside: NDArray[np.bool_]) -> float:
    values = np.abs(residuals[inside])
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) >= _FEWEST else float("nan")


# ── what is printed ──────────────────────────────────────────────────────────────────────


def _print_decision(decision: Decision) -> None:
    who = f" {escape(decision.subject)}" if decision.subject else ""
    why = f": {decision.reason}" if decision.reason else ""
    console.print(f"{decision.verdict}{who}{why}", highlight=False)
    console.print(
        f"score {decision.score:.2f}, threshold {decision.threshold:.2f}", highlight=False
    )


def _print_heads(recognizer: FaceRecognizer, probe: Template, view: View, person: str) -> None:
    way = recognizer.pipeline
    cohort = recognizer.cohort and way.head_scores(probe, recognizer.cohort)
    scores = way.normalise(way.head_scores(probe, view), cohort)
    table = Table("head", escape(person), "best of the others")
    column = view.subjects.index(person)
    others = np.delete(scores, column, axis=1)
    for k, head in enumerate(way.heads):
        rival = others[k]
        known = np.isfinite(rival).any()
        table.add_row(
            head.describe.name,
            f"{scores[k, column]:+.2f}",
            f"{np.nanmax(rival):+.2f}" if known else "–",
        )
    console.print(table)


def _print_parts(parts: Sequence[Part], person: str) -> None:
    table = Table("region", f"distance to {escape(person)}, mm", "to others, mm", "evidence")
    for part in parts:
        says = "for" if part.evidence > 1 else "against" if part.evidence < 0 else "neither"
        if np.isfinite(part.evidence):
            table.add_row(
                part.name,
                f"{part.residual_mm:.1f}",
                f"{part.others_mm:.1f}",
                f"{part.evidence:+.1f} {says}",
            )
        else:
            table.add_row(part.name, "–", "–", "not seen")
    console.print(table)
