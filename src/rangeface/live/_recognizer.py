"""The live recogniser: frame in, everybody who is seen out."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Self

import numpy as np

from rangeface.errors import ParameterError
from rangeface.gallery import Gallery, View
from rangeface.live._evidence import Evidence
from rangeface.live._people import People
from rangeface.live._search import TAKEN_MM, Search
from rangeface.live._track import Rules, Track
from rangeface.live._view import LiveFrame
from rangeface.live._visits import Visit
from rangeface.pipeline import Trace
from rangeface.recognizer import FaceRecognizer
from rangeface.sources import Frame
from rangeface.types import Float64

#: A frame that is older than this when its faces have been followed is not looked at closely.
_LATE_S = 0.045
#: But so long without any look is too long.
_PATIENCE_S = 0.3
#: So many visits are kept; a program that runs for days writes them down in time.
_VISITS = 10_000


class LiveRecognizer:
    """Finds, follows and recognises everybody before a camera.

    Every face is followed from frame to frame; every few frames what they show together is
    compared with the gallery, and the evidence of these looks is added up until it suffices:
    for a name, for *unknown*, or it never does: *cannot tell*, with the reason. People are
    remembered for a while, with or without a name.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Calibrated.
    gallery : Gallery
        May change at any time.
    fmr : float
        Score that different people reach with this probability says nothing, see `Evidence`.
    fpir, fnir : float
        Error rates of a decision that are aimed at, see `rangeface.decide.sequential`.
    correlation : float
        Of two looks' evidence, 0 … 1: what `fmr` does not account for already, since a lasting
        likeness of two people counts in it.
    look_every : int
        Frames between two looks at an undecided face, ≥ 1; so many are combined.
    relook_s : float
        Between two looks at a decided face, s.
    search_every_s, search_again_s : float
        Between two searches for new faces, s; and where nothing has changed since the last.
    lost_after_s : float
        A face that was not seen for so long is gone, s.
    max_age_s : float
        Nothing is decided on a frame older than this, s.
    remember_s : float
        So long people without a name are known again, s.
    meet_after : int
        Looks at somebody without a name before they are compared with those remembered, ≥ 1.
    background : bool
        Search in a thread of its own, and look closely only at frames that are not late. False:
        search in `update`, for results that do not depend on the computer's speed.

    Attributes
    ----------
    people : People
        Everybody who is remembered.
    visits : deque of Visit
        Those that are over, oldest first; the last 10 000.

    Raises
    ------
    ParameterError
        The recogniser is not calibrated, or a number is out of range.

    Notes
    -----
    `update` is to be called from one thread. Frames that are too old, doubled or out of order
    are ignored and counted.
    """

    def __init__(
        self,
        recognizer: FaceRecognizer,
        gallery: Gallery,
        *,
        fmr: float = 0.001,
        fpir: float = 0.01,
        fnir: float = 0.01,
        correlation: float = 0.1,
        look_every: int = 4,
        relook_s: float = 1.0,
        search_every_s: float = 0.25,
        search_again_s: float = 2.0,
        lost_after_s: float = 0.5,
        max_age_s: float = 1.0,
        remember_s: float = 1800.0,
        meet_after: int = 4,
        background: bool = True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        for name, value in (("look_every", look_every), ("meet_after", meet_after)):
            if value < 1:
                raise ParameterError(f"{name}: must be ≥ 1, got {value}")
        for name, span in (("lost_after_s", lost_after_s), ("max_age_s", max_age_s)):
            if not span > 0:
                raise ParameterError(f"{name}: must be > 0, got {span}")
        rules = Rules(fpir, fnir, correlation, look_every)
        self._recognizer = recognizer
        self._gallery = gallery
        self._evidence = Evidence.of(recognizer, fmr)
        self._rules = rules
        self._relook_s = relook_s
        self._live = background
        self._lost_after_s = lost_after_s
        self._max_age_s = max_age_s
        self._clock = clock
        self._search = Search(
            recognizer.pipeline, every_s=search_every_s, again_s=search_again_s,
            background=background,
        )  # fmt: skip
        self.people = People(
            recognizer, threshold=partial(_shared, recognizer, fmr), remember_s=remember_s
        )
        self.visits: deque[Visit] = deque(maxlen=_VISITS)
        self._meet_after = meet_after
        self._tracks: list[Track] = []
        self._numbers = count(1)
        self._last_s = self._looked_s = -np.inf
        self._ignored = 0
        self._search_ms = 0.0
        self._view: View | None = None

    def update(self, frame: Frame) -> LiveFrame:
        """Take the next frame in.

        Parameters
        ----------
        frame : Frame
            Of any source.

        Returns
        -------
        LiveFrame
            Everybody who is followed now. `stale` where the frame was ignored.
        """
        times: dict[str, float] = {}
        age_s = self._clock() - frame.arrived_s
        if age_s > self._max_age_s or frame.time_s <= self._last_s:
            self._ignored += 1
            return self._answer(frame, times, stale=True)
        self._last_s = frame.time_s
        self._follow(frame, times)
        self._look(frame, times)
        self._welcome(frame, times)
        return self._answer(frame, times, stale=False)

    def closeup(self, number: int) -> Trace | None:
        """What the last frames show together of one face: its surface, ready to be enrolled.

        Parameters
        ----------
        number : int
            Of a track of the last answer.

        Returns
        -------
        Trace or None
            Up to the assessment; None where the track is gone or not in the last frame.
        """
        for track in self._tracks:
            if track.number == number and track.recent:
                return track.closeup(self._recognizer.pipeline)
        return None

    def finish(self) -> None:
        """Everybody who is still there leaves: the source has ended."""
        for track in self._tracks:
            self._take_leave(track)
        self._tracks = []

    def close(self) -> None:
        """End the background search."""
        self._search.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()

    # ── stages ───────────────────────────────────────────────────────────────────────────

    def _follow(self, frame: Frame, times: dict[str, float]) -> None:
        start = time.perf_counter()
        for track in self._tracks:
            track.advance(
                self._recognizer.pipeline, frame.image, frame.time_s, self._rules.combined
            )
        kept = _apart([t for t in self._tracks if frame.time_s - t.seen_s <= self._lost_after_s])
        for track in self._tracks:
            if track not in kept:
                self._take_leave(track)
        self._tracks = kept
        times["follow"] = 1e3 * (time.perf_counter() - start)

    def _look(self, frame: Frame, times: dict[str, float]) -> None:
        """One look a frame at most: at the face that has waited longest."""
        start = time.perf_counter()
        view = self._gallery.view()
        if view is not self._view:
            self._view = view
            self.people.forget_names(view.subjects)
        due = [t for t in self._tracks if t.seen_s == frame.time_s and self._is_due(t, frame)]
        if due and self._has_time(frame):
            track = min(due, key=lambda t: t.looks[-1].time_s if t.looks else t.since_s - 1.0)
            look = track.look(self._recognizer)
            self._looked_s = frame.time_s
            if self._clock() - frame.arrived_s <= self._max_age_s:
                track.learn(look, self._recognizer, view, self._evidence, self._rules)
                ready = track.decided and track.usable >= self._meet_after
                self._introduce(track, frame.time_s, ready=ready)
        times["look"] = 1e3 * (time.perf_counter() - start)

    def _has_time(self, frame: Frame) -> bool:
        """Whether a look, which takes a frame's time or two, would not make a late frame later.

        A computer on which every frame is late looks all the same, less often.
        """
        on_time = self._clock() - frame.arrived_s < _LATE_S
        return on_time or not self._live or frame.time_s - self._looked_s > _PATIENCE_S

    def _is_due(self, track: Track, frame: Frame) -> bool:
        if not track.looks:
            return track.recent >= self._rules.combined
        if not track.decided or (track.person is None and track.usable < self._meet_after):
            return track.since_look >= self._rules.combined
        return frame.time_s - track.looks[-1].time_s >= self._relook_s

    def _introduce(self, track: Track, time_s: float, *, ready: bool) -> None:
        """Give a track its person, as soon as there is a name, or enough to tell people apart."""
        template = track.template(self._recognizer.pipeline)
        subject = track.decision.subject
        if track.person is not None:
            self.people.seen(track.person, template, time_s)
            if subject is None:
                return
            person = self.people.name(track.person, subject, time_s)
        elif subject is not None or (ready and template is not None):
            present = {t.person for t in self._tracks if t.person is not None}
            person = self.people.meet(subject, template, time_s, present)
        else:
            return
        track.person, track.visits = person.number, person.visits

    def _take_leave(self, track: Track) -> None:
        """Remember a visit that is over; one that was too short to begin is none."""
        self._introduce(track, track.seen_s, ready=True)
        if track.looked:
            self.visits.append(track.visit(self._recognizer.pipeline))

    def _welcome(self, frame: Frame, times: dict[str, float]) -> None:
        """Begin a track for every face that the search has found."""
        start = time.perf_counter()
        tips = [track.nose_tip for track in self._tracks]
        found = self._search.offer(frame.image, tips, frame.time_s)
        for pose in () if found is None else found.poses:
            track = Track(next(self._numbers), pose, frame.time_s, frame.time_s)
            if self._is_new(track.nose_tip) and track.advance(
                self._recognizer.pipeline, frame.image, frame.time_s, self._rules.combined
            ):
                self._tracks.append(track)
        if found is not None:
            self._search_ms = found.took_ms
        times["welcome"] = 1e3 * (time.perf_counter() - start)
        times["search"] = self._search_ms

    def _is_new(self, tip: Float64) -> bool:
        return all(np.linalg.norm(t.nose_tip - tip) > 0.75 * TAKEN_MM for t in self._tracks)

    def _answer(self, frame: Frame, times: dict[str, float], *, stale: bool) -> LiveFrame:
        return LiveFrame(
            number=frame.number,
            time_s=frame.time_s,
            latency_ms=1e3 * (self._clock() - frame.arrived_s),
            tracks=tuple(t.view(max(frame.time_s, t.seen_s), self._rules) for t in self._tracks),
            people=len(self.people),
            times_ms=times,
            dropped=frame.dropped,
            ignored=self._ignored,
            stale=stale,
        )


def _shared(recognizer: FaceRecognizer, fmr: float, people: int) -> float:
    """Threshold of a search: its comparisons share the rate, as far as calibration can show."""
    least = 3.0 / recognizer.nonmated.size
    return recognizer.threshold(max(fmr / max(people, 1), least))


def _apart(tracks: list[Track]) -> list[Track]:
    """Of two tracks that have come to follow one face, the older one."""
    kept: list[Track] = []
    for track in tracks:
        if all(np.linalg.norm(track.nose_tip - k.nose_tip) > 0.4 * TAKEN_MM for k in kept):
            kept.append(track)
    return kept
