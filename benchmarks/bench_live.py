"""A frame of the live recogniser: following two faces, looking closely at one, reading a frame.

For minutes on end, with latency, dropped frames and memory: `python -m benchmarks.live_soak`.
"""

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from rangeface.app.models import load_model
from rangeface.gallery import MemoryGallery
from rangeface.live._search import Search
from rangeface.live._track import Track
from rangeface.sensors import preset
from rangeface.sources import (
    Frame,
    Recorder,
    SyntheticCamera,
    comings_and_goings,
    enrolment,
    open_source,
)

SIZES = {"176 × 144": ("sr3000", 30.0), "640 × 480": ("structured-light", 15.0)}
_FRAMES = 8


def stages() -> Iterator[tuple[str, str, dict[str, Callable[[], object]]]]:
    """Yield the stage, its size and the arms, each a callable without arguments."""
    recognizer = load_model(None)
    for size, (sensor, rate_hz) in SIZES.items():
        gallery = MemoryGallery()
        gallery.enroll("known", recognizer.template(enrolment(sensor, 0), augment=True))
        frames = _two_people(sensor, rate_hz)
        tracks = [Track(k, _pose(frames[0], k), 0.0, 0.0) for k in range(2)]
        yield "live: follow two faces", size, {"ours": _follow(recognizer, tracks, frames)}
        look = _follow(recognizer, tracks, frames)
        for _ in range(_FRAMES):
            look()
        yield "live: look closely", size, {"ours": lambda r=recognizer, t=tracks[0]: t.look(r)}
        yield "live: search", size, {"ours": _search(recognizer, frames)}
        yield "live: read a recorded frame", size, {"ours": _read(frames)}


def _two_people(sensor: str, rate_hz: float) -> list[Frame]:
    walks = comings_and_goings(preset(sensor), [0, 900])
    camera = SyntheticCamera(sensor, walks, rate_hz=rate_hz, keep=False)
    start = int(3.5 * rate_hz)  # both stand still then
    frames = [f for _, f in zip(range(start + _FRAMES), camera, strict=False)]
    return frames[start:]


def _pose(frame: Frame, person: int):
    return frame.truth[person].pose.inverse()


def _follow(recognizer, tracks: list[Track], frames: list[Frame]) -> Callable[[], object]:
    state = {"next": 0}

    def call() -> object:
        frame = frames[state["next"] % len(frames)]
        state["next"] += 1
        return [t.advance(recognizer.pipeline, frame.image, frame.time_s, 4) for t in tracks]

    return call


def _search(recognizer, frames: list[Frame]) -> Callable[[], object]:
    search = Search(recognizer.pipeline, every_s=0.0, again_s=0.0, background=False)
    state = {"next": 0}

    def call() -> object:
        state["next"] += 1
        return search.offer(frames[state["next"] % len(frames)].image, [], float(state["next"]))

    return call


def _read(frames: list[Frame]) -> Callable[[], object]:
    path = Path(tempfile.mkdtemp()) / "frames.mcap"
    with Recorder(path) as recorder:
        for frame in frames:
            recorder.write(frame)
    source = iter(open_source(f"mcap:{path}", speed=None, repeat=True))
    return lambda: next(source)
