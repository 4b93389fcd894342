"""Table 8: a time-of-flight camera, single averages and sequences, another day than training.

A person sits 40 cm before a SwissRanger SR-3000 on two days. Twenty times on each day ten
successive frames are averaged, as the paper does; the first day's averages are learnt, the second
day's are probes, so that no probe shares a frame with training.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from rangeface import denoise, describe, register, sensors, simulate
from rangeface.evaluation.experiments._experiment import Experiment, Results, ordering
from rangeface.evaluation.experiments.clean_scans import N3, OURS, TESTS, mlda, rated
from rangeface.evaluation.experiments.sources import Source, head_of
from rangeface.evaluation.experiments.stages import RECTANGLE, SLICES, WIDE, frontals, recognition
from rangeface.evaluation.findings import Entry, Findings, Table, judge
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.pipeline import Step, step
from rangeface.types import RangeImage

AVERAGES, OVER, FRAMES = 20, 10, 60
#: Somebody who tries to sit still.
STILL = simulate.Motion(sway_mm=2.0, yaw_deg=3.0, pitch_deg=2.0, roll_deg=1.0)
FEATURES = {
    "depth (range image)": step(describe.depth),
    "LBP8,1 riu2": step(describe.lbp, sigma_px=0.0),
    "surface normals": N3,
}
#: Test image, test sequence; %.
PAPER = {
    "depth (range image)": (79, 79),
    "LBP8,1 riu2": (71, 79),
    "surface normals": (83, 83),
}
TITLE = "Table 8: time of flight"


@kept
def averages(
    store: Store,
    *,
    source: Source,
    session: int,
    register: Step,
    frontal: Step,
    segment: Step = SLICES,
) -> Arrays:
    """Frontal images of averages of ten successive frames, begun at random: 20 a person."""
    images = (i for person in source.numbers for i in averages_of(source, person, session))
    arrays = frontals(images, segment, register, frontal)
    people = source.persons
    for plane in ("depth", "sigma"):
        arrays[plane] = arrays[plane].reshape(people, AVERAGES, *arrays[plane].shape[2:])
    arrays["stage"] = arrays["stage"].reshape(people, AVERAGES)
    return {"owner": np.arange(people), **arrays}


def averages_of(source: Source, person: int, session: int) -> Iterator[RangeImage]:
    """The averages of ten successive frames of a person on one day, always the same."""
    rng = np.random.default_rng([person, session, 0x70F])
    starts = rng.integers(0, FRAMES - OVER + 1, AVERAGES)
    head = head_of(source, person, expression="neutral", session=session)
    motion = replace(STILL, seed=int(rng.integers(1 << 30)))
    frames = [
        frame.image
        for frame in simulate.sequence(
            [head], sensors.preset("sr3000"), motions=[motion], frames=FRAMES, oversample=3, rng=rng
        )
    ]
    return (denoise.combine.mean(frames[start : start + OVER]) for start in starts)


def cells(source: Source) -> list[Cell]:
    """A cell a feature, and ours."""
    source.need_heads("table8")
    return [cell_of(source, feature) for feature in FEATURES.values()] + [ours(source)]


def cell_of(source: Source, feature: Step) -> Cell:
    """Recognition on the second day from the first, unregistered."""
    return _cell(source, feature, step(register.none), RECTANGLE.step(), mlda())


def ours(source: Source) -> Cell:
    """Our pipeline on the same averages."""
    return _cell(source, step(describe.normals), step(register.icp), WIDE.step(), mlda(100))


def _cell(source: Source, feature: Step, turn: Step, frontal: Step, classifier: Step) -> Cell:
    days = [
        cell(averages, source=source, session=session, register=turn, frontal=frontal)
        for session in (0, 1)
    ]
    return cell(
        recognition, training=(days[0],), probes=days[1], feature=feature, classifier=classifier
    )


def tabulate(source: Source, results: Results) -> Findings:
    """The paper's layout."""
    at = {name: cell_of(source, feature) for name, feature in FEATURES.items()}
    rows = [
        [name]
        + [
            Entry(rated(results, at[name], test), printed)
            for test, printed in zip(TESTS, PAPER[name], strict=True)
        ]
        for name in FEATURES
    ]
    rows.append([OURS, *(Entry(rated(results, ours(source), test)) for test in TESTS)])
    depth, lbp, normals = at.values()
    verdicts = judge(
        [
            ordering(results, "Normals are the best (image)", [normals], [depth, lbp]),
            ordering(
                results, "Normals are the best (sequence)", [normals], [depth, lbp],
                test=TESTS["sequence"],
            ),
        ]
    )  # fmt: skip
    caption = "Rank 1, % [95 %] (paper); MLDA with 180 eigenvectors and α = 6"
    header = ["feature", *(f"test {test}" for test in TESTS)]
    return Findings(
        TITLE, "Do a time-of-flight camera's averages recognise people on another day?",
        readings=list(READINGS), tables=[Table("table8", caption, header, rows)],
        verdicts=verdicts,
        shown=("surface normals, test image", normals),
    )  # fmt: skip


READINGS = (
    "Simulated SwissRanger SR-3000, 176 × 144 pixels, nose tip at 40 cm; people try to sit still "
    "(± 2 mm, ± 3°).",
    "A test image is the mean of ten successive frames begun at random; a test sequence is twenty "
    "of them, decided by majority. Test averages share frames with each other, none with training.",
    "Training: twenty averages a person from another day; unregistered, 100 × 160 mm.",
    "The paper's 24 people sat before the camera once; our second day is harder.",
)

EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=24, minutes=3.0)
