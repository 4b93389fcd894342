"""Table 5: four profiles, by the direction of the face.

Each person's best profile is enrolled: the one that is most alike to the person's others. All
others are compared with everybody's best by Pearson's coefficient.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rangeface import classify, describe, register
from rangeface.errors import ParameterError
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments._experiment import Experiment, Results
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.experiments.stages import Crop, crops, features, scans
from rangeface.evaluation.findings import Claim, Entry, Findings, Table, judge
from rangeface.evaluation.grid import Arrays, Cell, Store, cell, kept
from rangeface.pipeline import Step, step

VIEWS = ("down", "up", "frontal1", "frontal2", "gesture", "laugh", "smile")
PROFILES = {
    "hor. nose-root": step(describe.horizontal_profile, at="root"),
    "hor. forehead": step(describe.horizontal_profile, at="forehead"),
    "hor. nose": step(describe.horizontal_profile, at="nose"),
    "vert. central": step(describe.vertical_profile),
}
#: Face direction → views; the paper's numbers in the order of `PROFILES`, %.
ROWS = {
    "down": (("down",), (60, 48, 63, 58)),
    "up": (("up",), (37, 26, 37, 32)),
    "frontal 1": (("frontal1",), (41, 13, 21, 51)),
    "frontal 2": (("frontal2",), (37, 13, 21, 49)),
    "frontal 1 and 2": (("frontal1", "frontal2"), (39, 13, 21, 50)),
    "facial expression": (("gesture",), (38, 0, 26, 53)),
    "laughter": (("laugh",), (36, 13, 22, 48)),
    "smile": (("smile",), (38, 12, 25, 47)),
    "on average": (VIEWS, (41, 20, 31, 48)),
}
TITLE = "Table 5: profiles by face direction"
#: Registered, nothing filled in: a profile that is not there has the mean of what is.
_CROP = Crop(140.0, 224.0, fill=False)


def cells(source: Source) -> list[Cell]:
    """A cell a profile."""
    if source.kind == "rap3df":
        raise ParameterError("data: table5 needs face directions, which rap3df does not name")
    return [cell_of(source, profile) for profile in PROFILES.values()]


def cell_of(source: Source, profile: Step) -> Cell:
    """Comparison of all views with everybody's best, by one profile."""
    frontal = tuple(
        cell(
            crops, scans=cell(scans, source=source, view=view), frontal=_CROP.step(),
            register=step(register.icp),
        )
        for view in VIEWS
    )  # fmt: skip
    return cell(against_best, views=frontal, profile=profile)


@kept
def against_best(store: Store, *, views: tuple[Cell, ...], profile: Step) -> Arrays:
    """Every scan against the best scan of everybody.

    Returns
    -------
    dict
        "scores" (n, 1, people): NaN rows where the face was not acquired; "owner" (n,);
        "view" (n,): number of the view; "reference" (n,): whether the scan is the best of its
        person, and so no probe.
    """
    taken = [store.get(cell(features, crops=view, feature=profile)) for view in views]
    X = np.concatenate([t["X"][:, 0] for t in taken if t["X"].shape[2] > 1])
    owner = np.concatenate([t["owner"] for t in taken])
    view = np.repeat(np.arange(len(views)), [len(t["owner"]) for t in taken])
    shown = np.isfinite(X[:, 0])
    matcher = classify.PearsonMatcher().fit(X[shown])
    alike = np.full((len(X), len(X)), np.nan, np.float32)
    Z = matcher.transform(X[shown])
    alike[np.ix_(shown, shown)] = matcher.similarity(Z, Z)
    best = [_best(alike, np.flatnonzero((owner == p) & shown)) for p in range(owner.max() + 1)]
    scores = np.full((len(X), 1, len(best)), np.nan, np.float32)
    for person, row in enumerate(best):
        if row >= 0:
            scores[:, 0, person] = alike[:, row]
    return {
        "scores": scores, "owner": owner, "view": view,
        "reference": np.isin(np.arange(len(X)), best),
    }  # fmt: skip


def _best(alike: NDArray[np.float32], own: NDArray[np.intp]) -> int:
    if not len(own):
        return -1
    return int(own[np.argmax(alike[np.ix_(own, own)].sum(axis=1))])


def recognised(result: Arrays, views: tuple[str, ...] = VIEWS) -> tuple[NDArray[np.bool_], ...]:
    """Hits and owners of the probes of some views; references are no probes."""
    keep = np.isin(result["view"], [VIEWS.index(v) for v in views]) & ~result["reference"]
    scores = result["scores"][keep, 0]
    best = np.argmax(np.where(np.isnan(scores), -np.inf, scores), axis=1)
    shown = np.isfinite(scores).any(axis=1)
    return (best == result["owner"][keep]) & shown, result["owner"][keep]


def entry(result: Arrays, views: tuple[str, ...], paper: float | None = None) -> Entry | str:
    """The rate of some views beside the paper's; a dash where every scan is a reference."""
    right, _ = recognised(result, views)
    return Entry(Rate.of(int(right.sum()), len(right)), paper) if len(right) else "–"


def tabulate(source: Source, results: Results) -> Findings:
    """The paper's layout."""
    found = {name: results(cell_of(source, profile)) for name, profile in PROFILES.items()}
    rows = [
        [
            direction,
            *(entry(found[name], views, p) for name, p in zip(PROFILES, paper, strict=True)),
        ]
        for direction, (views, paper) in ROWS.items()
    ]
    verdicts = judge(list(_claims(found)))
    caption = "Rank 1 by profile and face direction, % [95 %] (paper); Pearson's coefficient"
    return Findings(
        TITLE, "Is a profile enough, and in which direction must the face look?",
        readings=list(READINGS),
        tables=[Table("table5", caption, ["face direction", *PROFILES], rows)],
        verdicts=verdicts,
    )  # fmt: skip


def _claims(found: Mapping[str, Arrays]) -> Iterator[Claim]:
    """What section 4 says of profiles."""
    strong, weak = ("vert. central", "hor. nose-root"), ("hor. forehead", "hor. nose")
    others = tuple(view for view in VIEWS if view != "down")

    def claim(text: str, first: _Group, second: _Group) -> Claim:
        one, other = (_by_person(found, *group) for group in (first, second))
        people = sorted(one.keys() & other.keys())
        return Claim(text, "paper", [one[p] for p in people], [other[p] for p in people], people)

    yield claim("Vertical central and nose-root profiles are the best",
                (strong, VIEWS), (weak, VIEWS))  # fmt: skip
    yield claim("The forehead profile is the weakest (against the other three)",
                ((*strong, "hor. nose"), VIEWS), (("hor. forehead",), VIEWS))  # fmt: skip
    yield claim("Profiles are particularly good when the person looks down",
                (tuple(PROFILES), ("down",)), (tuple(PROFILES), others))  # fmt: skip
    yield claim("Expressions do less harm than looking up",
                (tuple(PROFILES), ("gesture", "laugh", "smile")),
                (tuple(PROFILES), ("up",)))  # fmt: skip


#: Profiles and views.
_Group: TypeAlias = tuple[tuple[str, ...], tuple[str, ...]]


def _by_person(
    found: Mapping[str, Arrays], names: tuple[str, ...], views: tuple[str, ...]
) -> dict[int, float]:
    pairs = [recognised(found[name], views) for name in names]
    right, owner = (np.concatenate(part) for part in zip(*pairs, strict=True))
    return {int(p): float(right[owner == p].mean()) for p in np.unique(owner)}


READINGS = (
    "Each person's best profile is the one most alike, on average, to the person's own others; "
    "it is the reference, and never a probe (no self-matches).",
    "61 people × 7 scans = the paper's 427 comparisons; a face that was not registered is an "
    "error.",
    "Faces are registered by ICP to a reference face; the second horizontal column, garbled in "
    "our copy of the paper, is read as the forehead profile.",
    "The heights: the root of the nose is found on the central line, the forehead is 28 mm "
    "above it.",
)

EXPERIMENT = Experiment(TITLE, cells, tabulate, persons=61, minutes=2.0)
