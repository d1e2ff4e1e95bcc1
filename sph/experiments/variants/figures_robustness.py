"""Runs at the ends of their keys' ranges."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from sph.figures.style import GREY, WIDTH, colour_map, label_panels, styled
from sph.storage.trajectory import Status


class Check(NamedTuple):
    """One panel: a column, how it is turned into 0 (good) to 1 (bad), and its title."""

    title: str
    badness: Callable[[pd.DataFrame], np.ndarray]


def _logarithm(column: str, good: float, bad: float) -> Callable[[pd.DataFrame], np.ndarray]:
    return lambda table: np.log10(np.maximum(np.abs(table[column].to_numpy()), good) / good) / np.log10(bad / good)


def _linear(column: str, good: float, bad: float) -> Callable[[pd.DataFrame], np.ndarray]:
    return lambda table: (np.abs(table[column].to_numpy()) - good) / (bad - good)


CHECKS = (
    Check("energy gap, 0.001 % to 10 %", _logarithm("energy_gap", 1e-5, 1e-1)),
    Check("change of area, 0 to 10 %", _linear("area_change", 0.0, 0.1)),
    Check("nearest distance, 1 to 0.5 spacings", _linear("nearest_p05", 1.0, 0.5)),
    Check("depth in walls, 0 to 1 spacing", _linear("penetration", 0.0, 1.0)),
)
"""What is shown, from good (light) to bad (dark)."""
REFUSED = "refused"
"""Status of a variant whose scene is refused before any work."""
MARKS: dict[str, str] = {Status.DIVERGED: "D", REFUSED: "R"}
"""What stands in the cell of a run without a result, by its status."""
DARKEST = 0.9
"""Part of the colour map that is used: beyond it text is hard to read."""


@styled
def figure_robustness(table: pd.DataFrame) -> Figure:
    """Every run of the sweeps: a row per sweep and case, a cell per value, a panel per check, coloured from good (light) to bad (dark);
    D diverged, R refused.

    ``table`` as from ``read_robustness``.  Raises ValueError for an empty one.
    """
    if table.empty:
        raise ValueError("table: no row to draw")
    groups = [(f"{sweep}, {case}", rows) for (sweep, case), rows in table.groupby(["sweep", "case"], sort=False)]
    longest = max(len(rows) for _, rows in groups)
    figure = Figure(figsize=(WIDTH, 1.0 + 0.13 * len(groups) * 2), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True, sharey=True)
    colours = colour_map("lajolla_r")
    for ax, check in zip(axes.flat, CHECKS, strict=True):
        for height, (_, rows) in enumerate(groups):
            badness = check.badness(rows)
            for place, (bad, status, value) in enumerate(zip(badness, rows["status"], rows["value"], strict=True)):
                failed = status in MARKS
                colour = "white" if failed or not np.isfinite(bad) else colours(DARKEST * float(np.clip(bad, 0.0, 1.0)))
                ax.add_patch(Rectangle((place, height), 1, 1, facecolor=colour, edgecolor=GREY, linewidth=0.3))
                text = MARKS.get(status, _short(value))
                dark = not failed and np.isfinite(bad) and bad > 0.55
                ax.text(place + 0.5, height + 0.5, text, ha="center", va="center", fontsize=5.4, color="white" if dark else "black")
        ax.set(xlim=(0, longest), ylim=(len(groups), 0), xticks=[])
        ax.set_yticks(np.arange(len(groups)) + 0.5, [name for name, _ in groups], fontsize=6.4)
        ax.tick_params(length=0)
        for spine in ax.spines.values():
            spine.set_visible(False)
    label_panels(axes.flat, [check.title for check in CHECKS])
    used = ListedColormap(colours(np.linspace(0.0, DARKEST, 256)))
    bar = figure.colorbar(ScalarMappable(cmap=used), ax=axes, orientation="horizontal", aspect=60, shrink=0.6, pad=0.01)
    bar.set_ticks([0.0, 1.0], labels=["first number of the title", "second or beyond"])
    bar.set_label("D: diverged, R: refused before any work", fontsize=7)
    return figure


def _short(value: str) -> str:
    """A value that fits into a cell."""
    try:
        number = f"{float(value):.3g}"
        return number if len(number) <= 6 else f"{float(value):.0e}"
    except ValueError:
        return value.removeprefix("wendland_").removesuffix("_spline")[:8]
