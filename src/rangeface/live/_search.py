"""The search of the whole image for faces that nobody follows yet."""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from rangeface.pipeline import FacePipeline
from rangeface.types import Float32, Float64, RangeImage, RigidTransform

#: Around a nose tip that is followed nobody else is looked for, mm.
TAKEN_MM = 200.0
#: Part of the coarse image that must have changed, by how much, before it is searched again.
_CHANGED, _CHANGE_MM = 0.02, 100.0


@dataclass(frozen=True)
class Found:
    """What a search found, and what it took."""

    poses: tuple[RigidTransform, ...]
    took_ms: float


class Search:
    """Looks for new faces, in the caller's thread or beside it, no more often than it must.

    A search takes several frames' time. In the background it works on one frame while the
    next ones are followed; what it finds is followed from then on.
    """

    def __init__(
        self, pipeline: FacePipeline, *, every_s: float, again_s: float, background: bool
    ) -> None:
        self._pipeline = pipeline
        self._every_s = every_s
        self._again_s = again_s
        self._pool = ThreadPoolExecutor(1, "search") if background else None
        self._running: Future[Found] | None = None
        self._began_s = -np.inf
        self._barren: Float32 | None = None  # what the last search in vain looked like
        self._offered: Float32 | None = None

    def offer(self, image: RangeImage, taken: Sequence[Float64], time_s: float) -> Found | None:
        """Begin a search if one is due; give what has been found since the last call."""
        found = self._harvest()
        if self._running is None and time_s - self._began_s >= self._every_s:
            coarse = _coarse(image, taken)
            if self._worth(coarse, time_s):
                self._began_s, self._offered = time_s, coarse
                if self._pool is None:
                    self._running = Future()
                    self._running.set_result(self._look(image, taken))
                    return self._harvest()
                self._running = self._pool.submit(self._look, image, taken)
        return found

    def close(self) -> None:
        """Let the background end."""
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)

    def _harvest(self) -> Found | None:
        if self._running is None or not self._running.done():
            return None
        found, self._running = self._running.result(), None
        self._barren = None if found.poses else self._offered
        return found

    def _worth(self, coarse: Float32, time_s: float) -> bool:
        """Whether anything may be there: something has changed, or the last look is long ago."""
        if self._barren is None or self._barren.shape != coarse.shape:
            return True
        if time_s - self._began_s >= self._again_s:
            return True
        return bool((np.abs(coarse - self._barren) > _CHANGE_MM).mean() > _CHANGED)

    def _look(self, image: RangeImage, taken: Sequence[Float64]) -> Found:
        start = time.perf_counter()
        denoised = self._pipeline.denoise(image)
        free = np.ones(image.shape, bool)
        for tip in taken:
            offset = denoised.points - np.asarray(tip, np.float32)
            free &= ~(np.einsum("ijk,ijk->ij", offset, offset) < TAKEN_MM**2)
        faces = self._pipeline.segment(denoised.masked(free))
        poses = tuple(face.pose for face in faces if face.pose is not None)
        return Found(poses, 1e3 * (time.perf_counter() - start))


def _coarse(image: RangeImage, taken: Sequence[Float64]) -> Float32:
    """Medians of 8 × 8 pixels, 0 where nothing or somebody known is seen."""
    rows, cols = (n // 8 * 8 for n in image.shape)
    blocks = np.nan_to_num(image.depth[:rows, :cols]).reshape(rows // 8, 8, cols // 8, 8)
    coarse: Float32 = np.median(blocks, axis=(1, 3)).astype(np.float32)
    for tip in taken:
        u, v = image.camera.project(tip) / 8.0
        reach = TAKEN_MM / image.camera.pixel_mm(float(tip[2])) / 8.0
        y, x = np.ogrid[: coarse.shape[0], : coarse.shape[1]]
        coarse[(x - u) ** 2 + (y - v) ** 2 < reach**2] = 0.0
    return coarse
