"""Is `default` better than the paper's best method, in each of the paper's settings?

The model that ships meets the very scans of tables 6, 7 and 8. It learns nothing there: people are
enrolled from the images that the paper's methods learn from.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import NoFaceError, ParameterError
from rangeface.evaluation.experiments import models, table6, table7, table8
from rangeface.evaluation.experiments._experiment import Experiment, Results, ordering, rate
from rangeface.evaluation.experiments.clean_scans import TESTS, cell_of, rated
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.experiments.stages import noisy, scans, unpack
from rangeface.evaluation.findings import Claim, Entry, Findings, Table, judge
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.gallery import stack
from rangeface.types import RangeImage, Template

#: The day of table 8's training, and that of its probes.
FIRST_DAY, SECOND_DAY = 0, 1
TITLE = "Best system: the model that ships, in the paper's settings"


# ── cells ────────────────────────────────────────────────────────────────────────────────


@kept
def of_scans(store: Store, *, scans: Cell, model: str, augment: bool) -> Arrays:
    """Templates of clean scans.

    Returns
    -------
    dict
        "owner" (n, k): whose image it is; "i.h": rows of head h of image i of n · k, none of an
        image that failed to acquire.
    """
    packed = store.get(scans)
    images = (unpack(packed, number) for number in range(len(packed["owner"])))
    return _templates(images, packed["owner"][:, None], model, augment)


@kept
def of_noisy_scans(
    store: Store, *, scans: Cell, model: str, sigma_mm: float, seed: tuple[int, ...]
) -> Arrays:
    """Templates of scans with the noise of table 7; as `of_scans`."""
    packed = store.get(scans)
    images = noisy(packed, sigma_mm, seed)
    return _templates(images, packed["owner"][:, None], model, augment=False)


@kept
def of_averages(store: Store, *, source: Source, model: str, session: int, augment: bool) -> Arrays:
    """Templates of the averages of table 8, twenty a person; as `of_scans`."""
    images = (
        image for person in source.numbers for image in table8.averages_of(source, person, session)
    )
    owner = np.repeat(np.arange(source.persons)[:, None], table8.AVERAGES, axis=1)
    return _templates(images, owner, model, augment)


def _templates(
    images: Iterable[RangeImage], owner: NDArray[np.int_], model: str, augment: bool
) -> dict[str, NDArray[np.generic]]:
    asked = models.recognizer(model)
    made: dict[str, NDArray[np.generic]] = {"owner": owner}
    for number, image in enumerate(images):
        try:
            template = asked.template(image, augment=augment)
        except NoFaceError:
            continue
        made |= {f"{number}.{h}": rows for h, rows in enumerate(template.vectors)}
    return made


@kept
def recognised(store: Store, *, model: str, enrolled: tuple[Cell, ...], probes: Cell) -> Arrays:
    """Every probe against everybody who is enrolled.

    Returns
    -------
    dict
        "scores" (n, k, people) float32, NaN where one of the two failed to acquire; "owner" (n,).
    """
    asked = models.recognizer(model)
    fingerprint = asked.pipeline.fingerprint
    known = [
        (str(owner), template)
        for one in enrolled
        for owner, template in _made(store.get(one), fingerprint)
        if template is not None
    ]
    references = stack(known, fingerprint)
    place = [int(subject) for subject in references.subjects]
    came = store.get(probes)
    owner = came["owner"]
    people = 1 + max(int(store.get(one)["owner"].max()) for one in (*enrolled, probes))
    scores = np.full((owner.size, people), np.nan, np.float32)
    for row, (_, template) in zip(scores, _made(came, fingerprint), strict=True):
        if template is not None and known:
            row[place] = asked.scores(template, references)
    return {"scores": scores.reshape(*owner.shape, people), "owner": owner[:, 0]}


def _made(arrays: Arrays, fingerprint: str) -> Iterator[tuple[int, Template | None]]:
    """Owner and template of each image; None of an image that failed to acquire."""
    heads = len({name.split(".")[1] for name in arrays if name != "owner"})
    for number, owner in enumerate(arrays["owner"].ravel().tolist()):
        shown = f"{number}.0" in arrays
        rows = tuple(arrays[f"{number}.{h}"] for h in range(heads)) if shown else ()
        yield owner, Template(rows, fingerprint) if shown else None


# ── settings ─────────────────────────────────────────────────────────────────────────────


class Setting(NamedTuple):
    """One of the paper's settings, its best method there, and ours."""

    name: str
    probe: str
    method: str
    printed: float
    paper: Cell
    default: Cell
    test: str = "image"


def cells(source: Source) -> list[Cell]:
    """The paper's best method and `default` in each setting."""
    if source.kind == "rap3df":
        raise ParameterError("data: best_system needs neutral and smiling probes: not rap3df:PATH")
    pairs = ((setting.paper, setting.default) for setting in settings(source))
    return list(dict.fromkeys(one for pair in pairs for one in pair))


def settings(source: Source) -> list[Setting]:
    """Tables 6 and 7, and of people that can be simulated table 8."""
    found = [_clean(source, probe) for probe in source.probes]
    found += [_noisy(source, psnr, probe) for psnr, probe in _noises(source)]
    return found + (list(_time_of_flight(source)) if source.simulated else [])


def _noises(source: Source) -> list[tuple[float, str]]:
    return list(product(sorted(table7.LEVELS, reverse=True), source.probes))


def _clean(source: Source, probe: str) -> Setting:
    def percent(method: str) -> int:
        return table6.PAPER[method][probe == "smiling"]

    best, view = max(table6.METHODS, key=percent), source.probes[probe]
    return Setting(
        "table 6, clean scans", probe, best, percent(best),
        cell_of(source, *table6.METHODS[best], view=view),
        _asked(source, cell(of_scans, **_seen(source, view), augment=False)),
    )  # fmt: skip


def _noisy(source: Source, psnr_db: float, probe: str) -> Setting:
    view = source.probes[probe]
    tried = [
        table7.Condition("scan", psnr_db, denoiser, "clean", system, classifier, view)
        for system, classifier, denoiser in product(
            table7.READ_AS.values(), table7.CLASSIFIERS, table7.DENOISERS
        )
    ]
    printed = {c: p for c in tried if (p := table7.printed(c, probe)) is not None}
    best = max(printed, key=printed.__getitem__)
    noise = table7.noise_of(source, view, psnr_db)
    return Setting(
        f"table 7, {psnr_db:.2f} dB on the range image", probe,
        f"{best.classifier} for {best.system}, {best.denoiser}", printed[best],
        table7.cell_of(source, best),
        _asked(source, cell(of_noisy_scans, **_seen(source, view), **noise)),
    )  # fmt: skip


def _time_of_flight(source: Source) -> Iterator[Setting]:
    sitters = replace(source, persons=min(source.persons, table8.EXPERIMENT.persons))
    model = models.shipped()
    enrolled, probes = (
        cell(of_averages, source=sitters, model=model, session=day, augment=day == FIRST_DAY)
        for day in (FIRST_DAY, SECOND_DAY)
    )
    default = cell(recognised, model=model, enrolled=(enrolled,), probes=probes)
    for number, test in enumerate(TESTS):
        best = max(table8.PAPER, key=lambda feature: table8.PAPER[feature][number])
        yield Setting(
            "table 8, SR-3000, another day", f"test {test}", f"MLDA for {best}",
            table8.PAPER[best][number], table8.cell_of(sitters, table8.FEATURES[best]),
            default, test,
        )  # fmt: skip


def _asked(source: Source, probes: Cell) -> Cell:
    """`default` with people enrolled from the training views."""
    enrolled = tuple(
        cell(of_scans, **_seen(source, view), augment=True) for view in source.training
    )
    return cell(recognised, model=models.shipped(), enrolled=enrolled, probes=probes)


def _seen(source: Source, view: str) -> dict[str, Cell | str]:
    return {"scans": cell(scans, source=source, view=view), "model": models.shipped()}


# ── what comes of it ─────────────────────────────────────────────────────────────────────


def tabulate(source: Source, results: Results) -> Findings:
    """A row a setting, and a claim a setting."""
    found = settings(source)
    rows = [
        [
            s.name, s.probe, s.method, f"{s.printed:g}",
            *(Entry(rated(results, one, s.test)) for one in (s.paper, s.default)),
            *(Entry(rate(lost)) for lost in _lost(results(s.default)["scores"], s.test)),
        ]
        for s in found
    ]  # fmt: skip
    header = [
        "setting", "probe", "the paper's best method", "the paper prints", "that method here",
        "default", "FTA of default", "FTE of default",
    ]  # fmt: skip
    caption = "Rank 1 of `default` beside the paper's best method, % [95 %]; FTA counts as an error"
    return Findings(
        TITLE, "Is `default` better than the paper's best method, in each of its settings?",
        readings=list(READINGS), tables=[Table("best_system", caption, header, rows)],
        verdicts=judge([_claim(results, s) for s in found]),
    )  # fmt: skip


def _claim(results: Results, s: Setting) -> Claim:
    text = f"Default is better than {s.method} ({s.name}, {s.probe})"
    return ordering(
        results, text, [s.default], [s.paper], test=TESTS[s.test], source="ours"
    )  # fmt: skip


def _lost(scores: NDArray[np.float32], test: str) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Probes that failed to acquire; people with whom nobody was ever compared."""
    missing = np.isnan(scores)
    asked = missing[:, :1] if test == "image" else missing
    not_acquired: NDArray[np.bool_] = np.asarray(asked.all(axis=(1, 2)))
    not_enrolled: NDArray[np.bool_] = np.asarray(missing.all(axis=(0, 1)))
    return not_acquired, not_enrolled


READINGS = (
    "The paper's best is the method with the highest number that the paper prints for a setting, "
    "with or without its denoiser; “that method here” is the cell of our table 6, 7 or 8.",
    "`default` is the model that ships. It learns nothing from these people, but has learned from "
    "other simulated people of our population, who smiled and laughed too, before other cameras "
    "(an SR-3000 among them): on a population of its own kind it has the advantage. The paper's "
    "methods learn from the images that it enrols: frontal 1 and the smile, in table 8 twenty "
    "averages of the first day.",
    "The same scans and the same noise for both. Nothing is denoised before `default`.",
    "A test sequence is twenty averages, decided by majority.",
    "FTA: test images, or whole sequences, of which no face was acquired; they count as errors. "
    "FTE: people of whom no training image was acquired.",
)

EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=60, minutes=5.0)
