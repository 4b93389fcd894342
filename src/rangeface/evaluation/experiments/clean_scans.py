"""What tables 1 to 4, 6 and the sweeps share: clean, unregistered scans, and the paper's features.

Training: frontal 1 and the smile with twelve rotations each. A *test image* is a probe scan, a
*test sequence* the scan and its twelve rotations, decided by majority.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rangeface import classify, describe, register
from rangeface.evaluation.error_rates import Rate
from rangeface.evaluation.experiments._experiment import Results, hits, rate, sequence_hits
from rangeface.evaluation.experiments.sources import Source
from rangeface.evaluation.experiments.stages import (
    RECTANGLE,
    SPHERE,
    TURNS_DEG,
    WIDE,
    Crop,
    crops,
    recognition,
    scans,
)
from rangeface.evaluation.findings import Entry, Table
from rangeface.evaluation.grid import Arrays, Cell, cell
from rangeface.pipeline import Step, step

#: The features of tables 2 and 3, in their order; nothing is smoothed beforehand.
FEATURES: Mapping[str, Step] = {
    "depth (range image)": step(describe.depth),
    "3DLBP layer 1": step(describe.tdlbp, layers=(1,), sigma_px=0.0),
    "3DLBP layer 2": step(describe.tdlbp, layers=(2,), sigma_px=0.0),
    "3DLBP layer 3": step(describe.tdlbp, layers=(3,), sigma_px=0.0),
    "3DLBP layer 4": step(describe.tdlbp, layers=(4,), sigma_px=0.0),
    "Horizontal Sobel Operator": step(describe.hso),
    "Large Horizontal Gradient": step(describe.lhg),
    "LBP8,1 u2": step(describe.lbp, method="u2", sigma_px=0.0),
    "LBP16,1 u2": step(describe.lbp, points=16, method="u2", sigma_px=0.0),
    "LBP16,2 riu2": step(describe.lbp, points=16, radius_px=2.0, sigma_px=0.0),
    "LBP8,1 ri": step(describe.lbp, method="ri", sigma_px=0.0),
    "LBP8,1 riu2": step(describe.lbp, sigma_px=0.0),
}
N3 = step(describe.n3, method="difference")
ARG = step(describe.normal_angle, unwrapped=False, method="difference")

#: Our pipeline in the paper's settings.
OURS = "ours: full normals, ICP"

CROPS = {"sphere-cropped": SPHERE, "rectangle-cropped": RECTANGLE}
#: Kinds of test, and what counts as recognised.
TESTS: Mapping[str, Callable[[Arrays], NDArray[np.bool_]]] = {
    "image": hits,
    "sequence": sequence_hits,
}

READINGS = (
    "Scans are unregistered: the nose tip is found, nothing is turned.",
    "Trained on frontal 1 and the smile, each with twelve rotations (±2.5°, ±5° about the three "
    "axes); neutral probes are frontal 2, smiling probes the laugh.",
    "A test sequence is the test scan and its twelve rotations, decided by majority.",
    "Rectangle: 100 × 160 mm around the nose tip; sphere: everything within 14 cm of it on a "
    "window of 175 × 280 mm; both on 50 × 80 pixels.",
    "LBP and 3DLBP compare grey values as they are: no smoothing beyond the resampling.",
    "“LDA with 180 eigenvectors” is PCA to 180 dimensions, then at most people − 1 directions; "
    "MLDA keeps the eigenvectors of positive value, at most people − 1, whatever their number.",
    "Intervals are Wilson's, 95 %; the paper gives none.",
)


def pca(count: int = 180) -> Step:
    """PCA with so many eigenvectors."""
    return Step(classify.PCA, (("n_components", count),))


def lda(count: int = 180) -> Step:
    """Fisherfaces after PCA to so many dimensions."""
    return Step(classify.FisherfaceLDA, (("n_pca", count),))


def mlda(count: int = 180, alpha: float = 6.0) -> Step:
    """MLDA with so many eigenvectors, and α."""
    return Step(classify.MLDA, (("alpha", alpha), ("n_components", count)))


def cell_of(
    source: Source, feature: Step, classifier: Step, *, view: str, crop: Crop = RECTANGLE
) -> Cell:
    """Recognition of a view from the paper's training."""
    return _cell(source, feature, classifier, view, crop, step(register.none))


def ours(source: Source, view: str) -> Cell:
    """Our pipeline on the same scans: ICP, 140 × 224 mm, all components of the normals."""
    classifier = mlda(100)
    return _cell(source, step(describe.normals), classifier, view, WIDE, step(register.icp))


def _cell(
    source: Source, feature: Step, classifier: Step, view: str, crop: Crop, turn: Step
) -> Cell:
    def seen(name: str) -> Cell:
        return cell(
            crops, scans=cell(scans, source=source, view=name), frontal=crop.step(),
            register=turn, turns_deg=TURNS_DEG,
        )  # fmt: skip

    return cell(
        recognition, training=tuple(seen(name) for name in source.training), probes=seen(view),
        feature=feature, classifier=classifier,
    )  # fmt: skip


def rated(results: Results, of: Cell, test: str) -> Rate:
    """The rate of a kind of test."""
    return rate(TESTS[test](results(of)))


def by_feature(
    name: str,
    caption: str,
    results: Results,
    *,
    at: Callable[[str, str], Cell],
    across: Iterable[str],
    paper: Mapping[str, Sequence[float | None]],
    own: Cell,
) -> Table:
    """Features downwards, ours last; across, for each kind of test, what they are combined with.

    Parameters
    ----------
    name, caption : str
        Of the table.
    results : Results
    at : callable
        (feature, name of a column) → cell.
    across : iterable of str
        Classifiers or crops.
    paper : mapping
        Feature → printed percentages, in the order of the columns.
    own : Cell
        Our pipeline on the same scans.

    Returns
    -------
    Table
    """
    columns = list(product(TESTS, across))
    rows: list[list[object]] = [
        [feature]
        + [
            Entry(rated(results, at(feature, column), test), percent)
            for (test, column), percent in zip(columns, printed, strict=True)
        ]
        for feature, printed in paper.items()
    ]
    rows.append([OURS] + [Entry(rated(results, own, test)) for test, _ in columns])
    header = ["feature", *(f"test {test} {column}" for test, column in columns)]
    return Table(name, caption, header, rows)
