"""`rangeface watch` and `rangeface record`: a camera without a page."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import typer
from rich.markup import escape
from rich.table import Table

from rangeface.app.console import console
from rangeface.app.models import load_model
from rangeface.gallery import open_gallery
from rangeface.live import LiveFrame, LiveRecognizer, TrackView, count_people, write_visits
from rangeface.sources import Frame, Newest, Reconnecting, Recorder, open_source

_DEVICES = ("realsense:", "orbbec:")


def watch(
    address: str,
    gallery: str | None,
    model: Path | None,
    *,
    fmr: float,
    speed: float,
    seconds: float | None,
    as_json: bool,
    visits: Path | None,
) -> None:
    """Print every decision as it falls, or every frame as a line of JSON; then the counts."""
    answers: list[LiveFrame] = []
    said: dict[int, str] = {}
    with (
        open_gallery(gallery or "memory://", create=gallery is None) as opened,
        LiveRecognizer(load_model(model), opened, fmr=fmr) as live,
    ):
        for frame in _frames(address, speed, seconds):
            answer = live.update(frame)
            answers.append(answer)
            if as_json:
                typer.echo(json.dumps(answer.as_dict()))
                continue
            for track in answer.tracks:
                if said.get(track.number) != (words := _words(track)):
                    said[track.number] = words
                    console.print(f"{answer.time_s:7.2f} s  face {track.number}: {words}",
                                  highlight=False)  # fmt: skip
        live.finish()
        if visits is not None:
            write_visits(visits, live.visits, source=address)
        if not as_json and answers:
            _summary(answers, live)


def record(address: str, target: Path, *, seconds: float | None) -> None:
    """Write a source's frames to an MCAP recording."""
    with Recorder(target) as recorder:
        for frame in _frames(address, 1.0, seconds):
            recorder.write(frame)
    console.print(f"{target}: {recorder.frames} frames", highlight=False)


def _frames(address: str, speed: float, seconds: float | None) -> Iterator[Frame]:
    """Newest frames of a source, devices opened again when they are unplugged, for a while."""
    source = (
        Reconnecting(lambda: open_source(address))
        if address.startswith(_DEVICES)
        else open_source(address, speed=speed)
    )
    with Newest(source) as newest:
        for frame in newest:
            if seconds is not None and frame.time_s >= seconds:
                return
            yield frame


def _words(track: TrackView) -> str:
    """A decision in words; evidence is left out, it changes with every look."""
    who = f" {escape(track.subject)}" if track.subject else ""
    why = f": {track.reason}" if track.reason else ""
    person = f" (person {track.person}, visit {track.visits})" if track.person else ""
    return f"{track.verdict}{who}{why}{person}"


def _summary(answers: list[LiveFrame], live: LiveRecognizer) -> None:
    counts = count_people(live.visits)
    console.print(
        f"{counts.different} different people, {counts.went_in} to the right, "
        f"{counts.went_out} to the left", highlight=False,
    )  # fmt: skip
    latency = [answer.latency_ms for answer in answers]
    table = Table("stage", "median ms", "p99 ms")
    for stage in dict.fromkeys(s for answer in answers for s in answer.times_ms):
        took = [a.times_ms[stage] for a in answers if stage in a.times_ms]
        table.add_row(stage, *_two(took))
    table.add_row("arrival to answer", *_two(latency))
    console.print(table)
    console.print(
        f"{len(answers)} frames, {answers[-1].dropped} dropped, {answers[-1].ignored} ignored",
        highlight=False,
    )


def _two(took: list[float]) -> tuple[str, str]:
    return f"{np.median(took):.1f}", f"{np.percentile(took, 99):.1f}"
