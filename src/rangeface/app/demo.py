"""`rangeface demo`: friends recognised and strangers refused, from images that look like snow."""

from __future__ import annotations

import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

import rangeface
from rangeface.app.console import console
from rangeface.app.models import load_model
from rangeface.app.progress import over
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.pictures import depth_rgb, png, shaded_rgb, tile, trace_figure
from rangeface.evaluation.report import Report
from rangeface.evaluation.synthetic import GALLERY, Visit, capture
from rangeface.gallery import MemoryGallery
from rangeface.pipeline import Trace
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Decision, Verdict

SENSOR, DISTANCE_MM = "sr3000", 400.0
FRAMES, GALLERY_FRAMES = 20, 10
FMR = 0.001
VISITS = (Visit("neutral", session=1), Visit("smile", expression="smile", session=1, yaw_deg=8.0))


@dataclass(frozen=True)
class Answer:
    """One probe: who it was, how it was seen, what was decided."""

    subject: str
    enrolled: bool
    kind: str
    trace: Trace
    decision: Decision

    @property
    def right(self) -> bool:
        """A friend by the right name, or a stranger without one."""
        return self.decision.subject == (self.subject if self.enrolled else None)


def run(out: Path, *, people: int, strangers: int, seed: int) -> None:
    """Enrol, recognise, refuse; print the table and write the report."""
    start = time.perf_counter()
    out.mkdir(parents=True, exist_ok=True)
    recognizer = load_model(None)
    friends = [1000 * seed + k for k in range(people)]
    others = [1000 * seed + people + k for k in range(strangers)]
    gallery, enrolments = _enrol(recognizer, friends)
    answers = [
        answer
        for person in over([*friends, *others], "recognising")
        for answer in _probe(recognizer, gallery, person, person in friends)
    ]
    table = _table(answers)
    _print(table, answers)
    path = out / "report.html"
    _report(recognizer, enrolments, answers, table).write(
        path,
        provenance=f"rangeface {rangeface.__version__}, Python {platform.python_version()}, "
        f"numpy {np.__version__}; rangeface demo --people {people} --strangers {strangers} "
        f"--seed {seed}; model {recognizer.pipeline.fingerprint[:12]}",
    )
    console.print(f"{path} ({time.perf_counter() - start:.0f} s)", highlight=False)


def _name(person: int) -> str:
    return f"person {person}"


def _capture(person: int, visit: Visit, frames: int) -> list[rangeface.RangeImage]:
    return capture(
        Path(f"{person}/{visit.view}"), person=person, visit=visit, sensor=SENSOR,
        distance_mm=DISTANCE_MM, frames=frames,
    )  # fmt: skip


def _enrol(
    recognizer: FaceRecognizer, friends: Sequence[int]
) -> tuple[MemoryGallery, dict[str, Trace]]:
    gallery, traces = MemoryGallery(), {}
    for person in over(friends, "enrolling"):
        trace = recognizer.pipeline.trace(_capture(person, GALLERY, GALLERY_FRAMES))
        if trace.frontal is None:
            console.print(f"{_name(person)} could not be enrolled: {trace.reason}")
            continue
        gallery.enroll(_name(person), recognizer.template(trace, augment=True))
        traces[_name(person)] = trace
    return gallery, traces


def _probe(
    recognizer: FaceRecognizer, gallery: MemoryGallery, person: int, enrolled: bool
) -> list[Answer]:
    answers = []
    for visit in VISITS:
        frames = _capture(person, visit, FRAMES)
        for kind, shown in (("single image", frames[0]), (f"{FRAMES} frames", frames)):
            trace = recognizer.pipeline.trace(shown)
            begin = time.perf_counter()
            decision = recognizer.identify(trace, gallery, fmr=FMR)
            trace.times_ms["decide"] = 1e3 * (time.perf_counter() - begin)
            answers.append(Answer(_name(person), enrolled, kind, trace, decision))
    return answers


def _table(answers: Sequence[Answer]) -> list[list[str]]:
    rows = []
    for kind in dict.fromkeys(a.kind for a in answers):
        mine = [a for a in answers if a.kind == kind]
        friends, others = [a for a in mine if a.enrolled], [a for a in mine if not a.enrolled]
        best = sum(
            bool(a.decision.ranking) and a.decision.ranking[0][0] == a.subject for a in friends
        )
        wrong = sum(a.decision.subject not in (None, a.subject) for a in friends)
        rows.append(
            [
                kind,
                str(Rate.of(best, len(friends))),
                str(Rate.of(sum(a.right for a in friends), len(friends))),
                str(Rate.of(wrong, len(friends))),
                str(Rate.of(sum(a.right for a in others), len(others))),
            ]
        )
    return rows


HEADER = (
    "probe",
    "best score is the right one",
    "friends accepted",
    "wrong name",
    "strangers refused",
)


def _stage_rows(answers: Sequence[Answer]) -> list[list[str]]:
    kinds = list(dict.fromkeys(a.kind for a in answers))
    stages = list(dict.fromkeys(stage for a in answers for stage in a.trace.times_ms))
    rows = []
    for stage in stages:
        cells = [stage]
        for kind in kinds:
            times = [
                a.trace.times_ms[stage]
                for a in answers
                if a.kind == kind and stage in a.trace.times_ms
            ]
            cells.append(f"{np.median(times):.1f}" if times else "–")
        rows.append(cells)
    return rows


def _print(table: Sequence[Sequence[str]], answers: Sequence[Answer]) -> None:
    shown = Table(*HEADER, title=f"SR-3000 at {DISTANCE_MM:.0f} mm, 95 % intervals (count of n)")
    for row in table:
        shown.add_row(*row)
    console.print(shown)
    kinds = list(dict.fromkeys(a.kind for a in answers))
    times = Table("stage, median ms", *kinds)
    for row in _stage_rows(answers):
        times.add_row(*row)
    console.print(times)


def _report(
    recognizer: FaceRecognizer,
    enrolments: dict[str, Trace],
    answers: Sequence[Answer],
    table: Sequence[Sequence[str]],
) -> Report:
    report = Report("rangeface: friends and strangers before a noisy depth camera")
    report.text(
        f"Simulated people, none of whom exists, stand {DISTANCE_MM:.0f} mm before a simulated "
        f"SwissRanger SR-3000 (176 × 144 pixels). {len(enrolments)} are enrolled from "
        f"{GALLERY_FRAMES} averaged frames; on another day they come back, neutral and smiling, "
        f"and so do strangers. The model was trained on other simulated people; a score is "
        f"accepted if different people reach it once in {1 / FMR:.0f} comparisons."
    )
    report.table(HEADER, table)
    report.heading("What the camera sees")
    _pictures_of_noise(report, answers)
    report.heading("The way of one face")
    for answer in answers[:2]:
        figure = trace_figure(answer.trace, recognizer.pipeline, f"{answer.subject}, {answer.kind}")
        report.picture(png(figure), f"Every stage: {answer.kind}.")
    report.heading("Who is enrolled")
    pictures = [shaded_rgb(t.frontal) for t in enrolments.values() if t.frontal is not None]
    report.picture(png(tile(pictures, list(enrolments), columns=8)), "The enrolled frontal faces.")
    report.heading("Decisions")
    _pictures_of_decisions(report, enrolments, answers)
    report.heading("Time of each stage")
    kinds = list(dict.fromkeys(a.kind for a in answers))
    report.table(("stage, median ms", *kinds), _stage_rows(answers))
    return report


def _pictures_of_noise(report: Report, answers: Sequence[Answer]) -> None:
    single = next(a for a in answers if a.kind == "single image")
    several = next(a for a in answers if a.kind != "single image" and a.subject == single.subject)
    pictures = [
        depth_rgb(single.trace.image), shaded_rgb(single.trace.image),
        depth_rgb(several.trace.image), shaded_rgb(several.trace.image),
    ]  # fmt: skip
    titles = [
        "depth, one frame",
        "shaded, one frame",
        f"depth, {several.kind}",
        f"shaded, {several.kind}",
    ]
    report.picture(png(tile(pictures, titles, columns=4), dpi=160), single.subject)


def _pictures_of_decisions(
    report: Report, enrolments: dict[str, Trace], answers: Sequence[Answer]
) -> None:
    rows = []
    friend = [a for a in answers if a.enrolled and a.right][:1]
    stranger = [a for a in answers if not a.enrolled and a.right and a.decision.ranking][:2]
    mistakes = [a for a in answers if not a.right][:6]
    for answer in [*friend, *stranger, *mistakes]:
        nearest = answer.decision.ranking[0][0] if answer.decision.ranking else None
        pictures, titles = [shaded_rgb(answer.trace.image)], [f"{answer.subject}, {answer.kind}"]
        if answer.trace.frontal is not None:
            pictures.append(shaded_rgb(answer.trace.frontal))
            titles.append("turned frontal")
        frontal = enrolments[nearest].frontal if nearest in enrolments else None
        if frontal is not None:
            pictures.append(shaded_rgb(frontal))
            titles.append(f"nearest: {nearest}")
        report.picture(png(tile(pictures, titles, columns=3), dpi=130), _sentence(answer))
    for answer in answers:
        decision = answer.decision
        rows.append(
            [answer.subject, "enrolled" if answer.enrolled else "stranger", answer.kind,
             str(decision.verdict), decision.subject or "–", f"{decision.score:.2f}",
             f"{decision.threshold:.2f}", decision.reason or "", "" if answer.right else "✗"]
        )  # fmt: skip
    report.table(
        ("who", "", "probe", "verdict", "name", "score", "needed", "reason", "mistake"), rows
    )


def _sentence(answer: Answer) -> str:
    decision = answer.decision
    if decision.verdict is Verdict.ACCEPTED:
        said = f"accepted as {decision.subject}"
    else:
        said = f"{decision.verdict}: {decision.reason}"
    role = "enrolled" if answer.enrolled else "a stranger"
    return (
        f"{answer.subject} ({role}): {said}; score {decision.score:.2f} of {decision.threshold:.2f}"
    )
