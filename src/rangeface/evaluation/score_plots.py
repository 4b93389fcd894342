"""Curves and distributions of a table of scores, as pictures."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rangeface.evaluation.comparisons import Comparisons
from rangeface.evaluation.curves import Curve, det
from rangeface.evaluation.pictures import canvas, shaded_rgb, tile
from rangeface.types import RangeImage

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_EMPTY = np.ones((80, 50, 3))
#: So many letters of a name's end fit above a picture.
_NAME = 24
_TICKS = np.array([0.001, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95])


def score_figure(comparisons: Comparisons) -> Figure:
    """ROC, DET, CMC and the distributions of scores, side by side.

    Parameters
    ----------
    comparisons : Comparisons
        With mated and non-mated scores.

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    DegenerateError
        One of the kinds is missing.
    """
    mated, nonmated = comparisons.split()
    curve = det(mated, nonmated)
    figure = canvas((12.0, 3.2))
    roc, detection, match, spread = figure.subplots(1, 4)
    _roc(roc, curve)
    _det(detection, curve)
    if comparisons.enrolled.any():
        _cmc(match, comparisons.cmc())
    else:
        match.set_axis_off()
    _distributions(spread, mated, nonmated)
    return figure


def pairs_figure(
    comparisons: Comparisons,
    probe: Callable[[int], RangeImage | None],
    reference: Callable[[int], RangeImage | None],
    *,
    count: int = 4,
) -> Figure:
    """The worst mated pairs (first row) and the worst non-mated ones, shaded.

    Parameters
    ----------
    comparisons : Comparisons
    probe, reference : callable
        Row, column → frontal image; None where there is none.
    count : int
        Pairs of each kind.

    Returns
    -------
    matplotlib Figure
    """
    pictures, titles = [], []
    for kind, pairs in zip(("mated", "non-mated"), comparisons.worst(count), strict=True):
        # a row of the picture is one kind, however few pairs there are
        for place in range(count):
            if place >= len(pairs):
                pictures += [_EMPTY, _EMPTY]
                titles += ["", ""]
                continue
            row, column = pairs[place]
            score = f"{kind}, {comparisons.table[row, column]:.3g}"
            for image, title in (
                (probe(row), f"{comparisons.probes[row][-_NAME:]}\n{score}"),
                (reference(column), f"{comparisons.references[column][-_NAME:]}\nenrolled"),
            ):
                pictures.append(_EMPTY if image is None else shaded_rgb(image))
                titles.append(title)
    return tile(pictures, titles, columns=2 * count)


def _roc(axis: Axes, curve: Curve) -> None:
    axis.plot(curve.fmr, 1.0 - curve.fnmr, drawstyle="steps-post")
    smallest = curve.fmr[curve.fmr > 0].min(initial=1.0)
    axis.set(title="ROC", xlabel="false match rate", ylabel="true match rate",
             xscale="log", xlim=(smallest, 1.0), ylim=(0.0, 1.02))  # fmt: skip
    axis.grid(alpha=0.3)


def _det(axis: Axes, curve: Curve) -> None:
    from scipy.special import ndtri

    inside = (curve.fmr > 0) & (curve.fmr < 1) & (curve.fnmr > 0) & (curve.fnmr < 1)
    x, y = (v[inside] for v in curve.probit())
    axis.plot(x, y, marker="." if inside.sum() < 3 else None)
    places, names = ndtri(_TICKS), [f"{100 * t:g}" for t in _TICKS]
    axis.set_xticks(places, names, fontsize=7)
    axis.set_yticks(places, names, fontsize=7)
    limits = (ndtri(0.0005), ndtri(0.97))
    axis.set(title="DET", xlabel="false match rate, %", ylabel="false non-match rate, %",
             xlim=limits, ylim=limits)  # fmt: skip
    axis.grid(alpha=0.3)
    if not inside.any():
        axis.text(0.5, 0.5, "no threshold with\nboth kinds of error", ha="center", va="center",
                  transform=axis.transAxes, fontsize=8)  # fmt: skip


def _cmc(axis: Axes, shares: NDArray[np.float64]) -> None:
    ranks = np.arange(1, len(shares) + 1)
    axis.plot(ranks, shares, marker=".", drawstyle="steps-post")
    axis.set(title="CMC", xlabel="rank", ylabel="found within", xlim=(0.8, min(20, len(ranks)) + 1),
             ylim=(min(0.5, shares[0] - 0.05), 1.02))  # fmt: skip
    axis.grid(alpha=0.3)


def _distributions(axis: Axes, mated: NDArray[np.float64], nonmated: NDArray[np.float64]) -> None:
    mated, nonmated = (v[np.isfinite(v)] for v in (mated, nonmated))
    both = np.concatenate([mated, nonmated])
    bins = np.linspace(both.min(), both.max(), 41).tolist()
    for values, name, colour in ((nonmated, "non-mated", "tab:red"), (mated, "mated", "tab:blue")):
        axis.hist(values, bins, density=True, alpha=0.55, color=colour, label=name)
    axis.set(title="scores", xlabel="score", yticks=[])
    axis.legend(fontsize=8)
