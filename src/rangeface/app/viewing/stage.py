"""The stage: one source, one recogniser, and what onlookers may ask of them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from threading import RLock, Thread

from rangeface import denoise
from rangeface.app.viewing.audience import Audience
from rangeface.app.viewing.closeups import Closeups
from rangeface.app.viewing.enrolment import Enrolment
from rangeface.app.viewing.recordings import Recordings
from rangeface.app.viewing.report import report
from rangeface.app.viewing.runs import Rate, Run
from rangeface.errors import GalleryError, ParameterError, RangeFaceError
from rangeface.gallery import Gallery
from rangeface.live import LiveFrame, LiveRecognizer
from rangeface.recognizer import FaceRecognizer
from rangeface.sources import Frame, Source
from rangeface.types import RangeImage

_TELL_EVERY = 15


class Stage:
    """Runs a source through the live recogniser in a thread of its own, and shows it.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Calibrated.
    gallery : Gallery
        Of the same model, or empty; the caller closes it.
    opener : callable
        Opens a source by its address.
    sources : mapping of str to str
        Address → what it is called: those among which onlookers may choose, and no others.
    recordings : Path
        Folder of the recordings.
    fmr : float
        As in `LiveRecognizer`.

    Notes
    -----
    Every public method may be called from any thread. What it refuses it raises as a
    `RangeFaceError` whose message is a sentence for the onlooker.
    """

    def __init__(
        self,
        recognizer: FaceRecognizer,
        gallery: Gallery,
        *,
        opener: Callable[[str], Source],
        sources: Mapping[str, str],
        recordings: Path,
        fmr: float = 0.001,
    ) -> None:
        self.audience = Audience()
        self._recognizer = recognizer
        self._gallery = gallery
        self._opener = opener
        self._sources = dict(sources)
        self._recordings = Recordings(recordings)
        self._fmr = fmr
        self._lock = RLock()
        self._run: Run | None = None
        self._number = 0
        self._ended = False
        self._problem: str | None = None
        self._denoiser = "none"
        self._followed: int | None = None
        self._enrolment: Enrolment | None = None

    # ── what runs ────────────────────────────────────────────────────────────────────────

    def choose(self, address: str) -> None:
        """Show another source, from its beginning.

        Raises
        ------
        ParameterError
            It is none of the sources that were offered.
        SourceError, ScanError
            It cannot be opened; what ran before goes on.
        """
        if address not in self._sources:
            raise ParameterError(f"source: {address!r} is not offered here")
        run = Run.of(address, self._opener(address))
        with self._lock:
            self._stop()
            self._ended, self._problem = False, None
            self._run = run
        Thread(target=self._play, args=(run,), name=f"stage {address}", daemon=True).start()
        self.tell()

    def close(self) -> None:
        """End the source and the recording."""
        with self._lock:
            self._stop()

    def play(self) -> None:
        """Go on; a source that has ended begins again."""
        run = self._running()
        if self._ended:
            self.choose(run.address)
        else:
            run.player.play()
        self.tell()

    def pause(self) -> None:
        """Hold the next frame back."""
        self._running().player.pause()
        self.tell()

    def step(self) -> None:
        """Show one frame while it is paused."""
        self._running().player.step()

    def clean(self, method: str) -> None:
        """Denoise every frame before it is looked at."""
        if method not in denoise.METHODS:
            raise ParameterError(f"denoising: unknown method {method!r}")
        self._denoiser = method
        self._settle()
        self.tell()

    def record(self, on: bool) -> None:
        """Begin or end a recording of the frames as they come from the source."""
        if on:
            self._recordings.begin()
        else:
            self._recordings.end()
        self.tell()

    # ── people ───────────────────────────────────────────────────────────────────────────

    def follow(self, track: int) -> None:
        """Show this face close up."""
        self._followed = track

    def enrol(self, subject: str, track: int) -> None:
        """Begin to enrol a face.

        Raises
        ------
        GalleryError
            The name is taken, or is none.
        """
        if not (0 < len(subject) <= 100 and subject.isprintable()):
            raise GalleryError("A name has 1 to 100 printable characters")
        if subject in self._gallery.subjects():
            raise GalleryError(f"{subject} is enrolled already; choose another name")
        self._followed, self._enrolment = track, Enrolment(subject, track)
        self._settle()
        self.tell()

    def cancel(self) -> None:
        """Forget what an enrolment has collected."""
        self._enrolment = None
        self.tell()

    def save(self) -> None:
        """Enrol with what has been collected.

        Raises
        ------
        GalleryError
            It does not suffice, or the gallery cannot be written.
        """
        with self._lock:
            enrolment = self._enrolment
            if enrolment is None or not enrolment.sufficient:
                raise GalleryError("Not enough has been seen yet: look straight ahead")
            self._gallery.enroll(enrolment.subject, enrolment.template(self._recognizer))
            self._enrolment = None
        self.tell()

    def delete(self, subject: str) -> None:
        """Remove a person and all their templates.

        Raises
        ------
        GalleryError
            Nobody of that name is enrolled.
        """
        self._gallery.delete(subject)
        self.tell()

    # ── what onlookers know ──────────────────────────────────────────────────────────────

    def state(self) -> str:
        """Everything but the frames, as JSON."""
        with self._lock:
            run, enrolment = self._run, self._enrolment
            return json.dumps({"state": {
                "sources": [{"name": n, "label": label} for n, label in self._sources.items()],
                "source": run.address if run else None,
                "playing": bool(run and run.player.playing and not self._ended),
                "ended": self._ended,
                "problem": self._problem,
                "recording": self._recordings.as_dict(),
                "denoiser": self._denoiser,
                "denoisers": list(denoise.METHODS),
                "gallery": [{"subject": subject} for subject in self._gallery.subjects()],
                "enrolment": enrolment and enrolment.as_dict(),
            }})  # fmt: skip

    def tell(self) -> None:
        """Tell all onlookers the state."""
        if len(self.audience):
            self.audience.tell(self.state())

    # ── in the thread of a run ───────────────────────────────────────────────────────────

    def _play(self, run: Run) -> None:
        """Look at every frame, until the source ends or another is chosen."""
        problem = None
        rate = Rate()
        try:
            with LiveRecognizer(self._recognizer, self._gallery, fmr=self._fmr) as live:
                closeups = Closeups()
                for frame in run.frames:
                    if run is not self._run:
                        return
                    self._take(frame, live, closeups, rate.tick())
        except (RangeFaceError, OSError) as error:
            problem = str(error)
        with self._lock:
            if run is not self._run:
                return
            self._ended, self._problem = True, problem
            self._recordings.end()
        self.tell()

    def _take(self, frame: Frame, live: LiveRecognizer, closeups: Closeups, fps: float) -> None:
        """Record, denoise, recognise, show."""
        self._recordings.write(frame)
        if self._number % _TELL_EVERY == 0 and self._recordings.as_dict():
            self.tell()  # how many frames the recording has
        image, denoise_ms = self._cleaned(frame.image)
        seen = live.update(replace(frame, image=image))
        self._look_closer(live, seen, closeups)
        self._number += 1
        if len(self.audience):
            times = {"denoise": denoise_ms, **seen.times_ms}
            self.audience.show(
                self._number,
                report(
                    self._number,
                    image,
                    seen,
                    fps=fps,
                    followed=self._followed,
                    surface=closeups.surface,
                    times_ms=times,
                ),
            )

    def _cleaned(self, image: RangeImage) -> tuple[RangeImage, float]:
        start = time.perf_counter()
        try:
            image = denoise.METHODS[self._denoiser](image)
        except RangeFaceError as error:  # a method that needs what this sensor does not know
            self._denoiser, self._problem = "none", str(error)
            self.tell()
        return image, 1e3 * (time.perf_counter() - start)

    def _look_closer(self, live: LiveRecognizer, seen: LiveFrame, closeups: Closeups) -> None:
        enrolment = self._enrolment
        self._followed = enrolment.track if enrolment else self._of_interest(seen)
        if not (enrolment or len(self.audience)) or not closeups.due():
            return
        here = {track.number for track in seen.tracks if track.lost_s == 0.0}
        look = closeups.look(live, self._followed if self._followed in here else None)
        if enrolment is None:
            return
        enrolment.take(look)
        if enrolment.complete:
            self._save_at_once()
        self.tell()

    def _save_at_once(self) -> None:
        """Save without being asked; a gallery that cannot be written does not end the view."""
        try:
            self.save()
        except RangeFaceError as error:
            self._enrolment, self._problem = None, str(error)

    def _of_interest(self, seen: LiveFrame) -> int | None:
        """The face that is followed, as long as it is there; then the nearest."""
        if any(track.number == self._followed for track in seen.tracks):
            return self._followed
        nearest = min(seen.tracks, key=lambda track: track.nose_tip_mm[2], default=None)
        return None if nearest is None else nearest.number

    def _settle(self) -> None:
        """A problem of an earlier command is over; that of a source stays until it plays again."""
        if not self._ended:
            self._problem = None

    # ── ends ─────────────────────────────────────────────────────────────────────────────

    def _running(self) -> Run:
        if self._run is None:
            raise ParameterError("source: none is chosen")
        return self._run

    def _stop(self) -> None:
        self._recordings.end()
        self._enrolment = self._followed = None
        if self._run is not None:
            run, self._run = self._run, None
            run.frames.close()
