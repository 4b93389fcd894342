"""An experiment of your own: cells, a store, a verdict.

Does a light smoothing save local binary patterns from noise? Sixteen people, one noise, two
features; what is computed is kept, so a second run takes a moment.
"""

import tempfile
from pathlib import Path

from rangeface import classify, denoise, describe, register
from rangeface.evaluation import grid
from rangeface.evaluation.experiments._experiment import hits, ordering, rate, results_of
from rangeface.evaluation.experiments.sources import source
from rangeface.evaluation.experiments.stages import RECTANGLE, crops, recognition, scans, spoiled
from rangeface.evaluation.findings import judge
from rangeface.pipeline import Step, step

FEATURES = {
    "LBP as it is": step(describe.lbp, sigma_px=0.0),
    "LBP, smoothed by 1 px": step(describe.lbp, sigma_px=1.0),
}


def main() -> dict[str, float]:
    people = source("synthetic", persons=16)

    def frontal(view: str) -> grid.Cell:
        taken = grid.cell(scans, source=people, view=view)
        turn = step(register.none)
        return grid.cell(crops, scans=taken, frontal=RECTANGLE.step(), register=turn)

    noise = {"sigma_mm": 2.0, "denoise": step(denoise.none), "seed": (0,)}
    cells = {
        name: grid.cell(
            recognition,
            training=(frontal("frontal1"), frontal("smile")),
            probes=grid.cell(spoiled, crops=frontal("frontal2"), **noise),
            feature=feature,
            classifier=Step(classify.PCA, (("n_components", 40),)),
        )
        for name, feature in FEATURES.items()
    }
    with tempfile.TemporaryDirectory() as folder:
        store = grid.Store(Path(folder))
        grid.run(list(cells.values()), store, grid.executor("serial"))
        results = results_of(store)
        rates = {name: rate(hits(results(cell))) for name, cell in cells.items()}
        plain, smoothed = cells.values()
        claim = ordering(results, "smoothing helps", [smoothed], [plain], source="example")
    for name, found in rates.items():
        print(f"{name:24s} {found}")
    print(f"{claim.text}: {judge([claim])[0].verdict}")
    return {name: found.rate for name, found in rates.items()}


if __name__ == "__main__":
    main()
