"""Does the model that ships recognise people of a population that it has never seen?

Heads of ICT-FaceKit (a user's own copy) before the SR-3000: one enrolment of ten frames a
person; on another day a neutral frame, twenty neutral frames, a smile and a laugh. Open set: as
many strangers as wished, twenty frames each. Nothing is learned from this population.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rangeface import sensors, simulate
from rangeface.errors import NoFaceError
from rangeface.evaluation.error_rates import Rate, fmr, fnmr, mated_nonmated, rank_k
from rangeface.evaluation.open_set import best_scores, fnir_at_fpir
from rangeface.evaluation.synthetic import window
from rangeface.gallery import stack
from rangeface.numerics.statistics import rule_of_three
from rangeface.recognizer import FaceRecognizer
from rangeface.simulate import MorphableModel
from rangeface.types import Float64, RangeImage

SENSOR, DISTANCE_MM = "sr3000", 400.0
#: An expression that is held is never quite the same: standard deviation of its strength.
_STRENGTH_SIGMA = 0.15
#: Nobody shows the same neutral face twice: some blend shapes are at work on the other day.
_RESTLESS = 0.12


class Visit(NamedTuple):
    """One capture of a person: what is shown, on which day, in how many frames."""

    expression: str
    session: int
    frames: int


ENROLMENT = Visit("neutral", 0, 10)
SEQUENCE = Visit("neutral", 1, 20)
PROBES = {
    "neutral, one frame": Visit("neutral", 1, 1),
    "neutral, 20 frames": SEQUENCE,
    "smile, 20 frames": Visit("smile", 1, 20),
    "laugh, 20 frames": Visit("laugh", 1, 20),
}


def run(
    *,
    recognizer: FaceRecognizer,
    ict: str | Path,
    seed: int = 0,
    people: int = 200,
    strangers: int = 1000,
    fpir: float = 0.01,
    cache: Path | None = None,
) -> dict[str, Any]:
    """Enrol, probe on another day, and let strangers try.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Calibrated; not changed.
    ict : str or Path
        The user's copy, as for `simulate.ict_facekit`.
    seed : int
        People are numbered from 100,000 · seed.
    people, strangers : int
        Enrolled and not.
    fpir : float
        Rate at which strangers may be taken for somebody.
    cache : Path, optional
        Folder for templates: a run that was cut off goes on.

    Returns
    -------
    dict
        Rank 1 of each kind of probe; FNIR at the wanted FPIR; and what the calibration's
        threshold at FMR 0.1 % gives here.
    """
    model = simulate.ict_facekit(ict)
    first = 100_000 * seed
    known = [first + k for k in range(people)]
    others = [first + people + k for k in range(strangers)]
    make = _Templates(recognizer, model, cache)
    enrolled = [(p, t) for p in known if (t := make(p, ENROLMENT)) is not None]
    references = stack(((str(p), t) for p, t in enrolled), recognizer.pipeline.fingerprint)
    columns = [str(p) for p in known]
    place = [columns.index(s) for s in references.subjects]

    def table(persons: Sequence[int], visit: Visit) -> Float64:
        scores = np.full((len(persons), len(columns)), np.nan)
        for row, person in zip(scores, persons, strict=True):
            template = make(person, visit)
            if template is not None:
                row[place] = recognizer.scores(template, references)
        return scores

    tables = {name: table(known, visit) for name, visit in PROBES.items()}
    result: dict[str, Any] = {
        "people": people, "strangers": strangers, "failed_to_enrol": people - len(enrolled),
        "rank1": {n: str(rank_k(t, columns, columns)) for n, t in tables.items()},
        "fta": {n: str(_failed(t)) for n, t in tables.items()},
        "at_calibrated_fmr_0.001": _at_threshold(recognizer, tables, columns),
    }  # fmt: skip
    if strangers:
        unknown = table(others, SEQUENCE)
        result["open_set"] = _open_set(tables, columns, unknown, fpir, recognizer)
    return result


def _open_set(
    tables: dict[str, Float64], columns: list[str], unknown: Float64, fpir: float,
    recognizer: FaceRecognizer,
) -> dict[str, Any]:  # fmt: skip
    best = best_scores(unknown)
    best = best[~np.isnan(best)]
    rate = max(fpir, rule_of_three(len(best)))
    let_in = {f"{f:g}": str(fmr(best, recognizer.threshold(f))) for f in (1e-3, 1e-4)}
    return {
        "fpir": rate,
        "fnir": {n: str(fnir_at_fpir(t, columns, columns, unknown, rate))
                 for n, t in tables.items()},
        "strangers_accepted_at_calibrated_fmr": let_in,
    }  # fmt: skip


def _at_threshold(
    recognizer: FaceRecognizer, tables: dict[str, Float64], columns: list[str]
) -> dict[str, dict[str, str]]:
    threshold = recognizer.threshold(0.001)
    out = {}
    for name, table in tables.items():
        mated, nonmated = mated_nonmated(table, columns, columns)
        out[name] = {"fmr": str(fmr(nonmated, threshold)), "fnmr": str(fnmr(mated, threshold))}
    return out


def _failed(table: Float64) -> Rate:
    return Rate.of(int(np.isnan(table).all(axis=1).sum()), len(table))


class _Templates:
    """Templates of visits, kept on disk where there is a cache."""

    def __init__(
        self, recognizer: FaceRecognizer, model: MorphableModel, cache: Path | None
    ) -> None:
        self.recognizer, self.model, self.cache = recognizer, model, cache
        if cache is not None:
            cache.mkdir(parents=True, exist_ok=True)

    def __call__(self, person: int, visit: Visit) -> Any:
        from rangeface.types import Template

        name = f"{self.recognizer.pipeline.fingerprint} {person} {visit}"
        path = self.cache and self.cache / f"{hashlib.sha256(name.encode()).hexdigest()[:24]}.npz"
        if path and path.is_file():
            with np.load(path, allow_pickle=False) as kept:
                vectors = tuple(kept[k] for k in kept.files)
        else:
            vectors = self._made(person, visit)
            if path:
                np.savez(path, *vectors)
        if not vectors:
            return None
        return Template(vectors, self.recognizer.pipeline.fingerprint)

    def _made(self, person: int, visit: Visit) -> tuple[NDArray[np.float32], ...]:
        try:
            seen = frames_of(self.model, person, visit)
            made = self.recognizer.template(
                seen if len(seen) > 1 else seen[0], augment=visit == ENROLMENT
            )
        except NoFaceError:
            return ()
        return tuple(np.asarray(v) for v in made.vectors)


def frames_of(model: MorphableModel, person: int, visit: Visit) -> list[RangeImage]:
    """The frames of one visit, always the same.

    Parameters
    ----------
    model : MorphableModel
    person : int
    visit : Visit

    Returns
    -------
    list of RangeImage
    """
    rng = np.random.default_rng([person, visit.session, visit.frames, *visit.expression.encode()])
    strength = float(np.clip(rng.normal(1.0, _STRENGTH_SIGMA), 0.5, 1.4))
    head = model.head(person, expression=visit.expression, strength=strength, session=visit.session)
    if visit.session:
        restless = model.head(
            person, expression="random", strength=_RESTLESS, session=visit.session
        )
        neutral = model.head(person)
        shift = restless.surface.points - neutral.surface.points
        surface = replace(head.surface, points=head.surface.points + shift)
        head = replace(head, surface=surface)
    yaw, pitch, roll = rng.normal(0.0, 3.0, 3)
    x, y = rng.normal(0.0, 10.0, 2)
    pose = simulate.pose(
        yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll, nose_tip_mm=(x, y, DISTANCE_MM)
    )
    sensor = sensors.preset(SENSOR)
    sensor = replace(sensor, camera=window(sensor.camera, DISTANCE_MM))
    scene = simulate.render(head, sensor.camera, pose, oversample=3)
    return list(simulate.frames(scene, sensor, visit.frames, rng=rng))
