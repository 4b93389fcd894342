"""Table and picture of `denoise_by_recognition`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from rangeface.evaluation.experiments.denoise_by_recognition import (
    CLASSIFIERS,
    DENOISERS,
    FEATURES,
    LEVELS,
)

_SITES = ("crop", "scan", "tof")


def table(result: Mapping[str, Any], *, population: str, training: str) -> str:
    """Rank-1 rates of every level and denoiser, as a Markdown table.

    Parameters
    ----------
    result : dict
        What `denoise_by_recognition.run` gave.
    population : {"ict", "own"}
        Whose rows.
    training : {"clean", "matched"}
        Trained on clean scans, or on scans with the probes' noise and denoiser.

    Returns
    -------
    str
        A row a cell; per feature PCA / MLDA, %.
    """
    lines = [
        "| noise | denoiser | gain dB | " + " | ".join(FEATURES) + " |",
        "|---|---|---" + "|---" * len(FEATURES) + "|",
    ]
    for cell in _ordered(result, population):
        rates = _rates(cell)
        entries = [
            " / ".join(f"{100 * rates[feature, c, training]:.0f}" for c in CLASSIFIERS)
            for feature in FEATURES
        ]
        gain = "" if cell["gain_db"] is None else f"{cell['gain_db']:.1f}"
        lines.append(f"| {cell['level']} | {cell['denoiser']} | {gain} | {' | '.join(entries)} |")
    return "\n".join(lines)


def draw(result: Mapping[str, Any], path: Path, *, population: str) -> Path:
    """Rate against noise, no denoising beside `auto`: a row a site, a column a feature (MLDA).

    Parameters
    ----------
    result : dict
        What `denoise_by_recognition.run` gave.
    path : Path
        PNG file to write.
    population : {"ict", "own"}
        Whose rates.

    Returns
    -------
    Path
    """
    cells = {(c["level"], c["denoiser"]): _rates(c) for c in _ordered(result, population)}
    figure = Figure(figsize=(12.0, 6.6), layout="constrained")
    axes = figure.subplots(len(_SITES), len(FEATURES), sharey=True, squeeze=False)
    for row, site in zip(axes, _SITES, strict=True):
        levels = [name for name in LEVELS if name.startswith(site)]
        for ax, feature in zip(row, FEATURES, strict=True):
            for denoiser, colour in (("none", "tab:red"), ("auto", "tab:blue")):
                for training, style in (("clean", "-"), ("matched", ":")):
                    rates = [
                        100 * cells[level, denoiser][feature, "MLDA", training]
                        if (level, denoiser) in cells
                        else np.nan
                        for level in levels
                    ]
                    label = f"{denoiser}, {training} training"
                    ax.plot(range(len(levels)), rates, style, color=colour, marker=".", label=label)
            ax.set_xticks(range(len(levels)), [name.removeprefix(f"{site} ") for name in levels])
            ax.tick_params(labelsize=7)
            ax.set_ylim(0, 100)
            ax.set_title(f"{site}: {feature}", fontsize=9)
        row[0].set_ylabel("rank 1, %")
    axes[0, 0].legend(fontsize=6, loc="lower left")
    figure.savefig(path, dpi=110)
    return path


def _ordered(result: Mapping[str, Any], population: str) -> list[Mapping[str, Any]]:
    cells = [c for c in result["cells"] if c["population"] == population]
    levels, denoisers = list(LEVELS), list(DENOISERS)
    return sorted(cells, key=lambda c: (levels.index(c["level"]), denoisers.index(c["denoiser"])))


def _rates(cell: Mapping[str, Any]) -> dict[tuple[str, str, str], float]:
    return {(f, c, t): rate for f, c, t, rate, *_ in cell["rates"]}
