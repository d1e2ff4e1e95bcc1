"""A study of any dimensions at a glance: displacement and run-out against each of them."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sph.figures.style import WIDTH, colour_map, plain, styled, write_note
from sph.measures.metrics import CLASSES, UNDETERMINED
from sph.study.dimensions import Dimension

SHOWN = {"displacement_magnitude": "displacement of {probe} (m)", "runout": "run-out (m)"}
"""The metrics that are drawn, and their words."""
MARKERS = "osD^"
"""Classes differ by these as well as by colour."""
COLUMNS = 3
"""Most panels side by side."""
LOG_FROM = 50.0
"""A dimension is drawn on a logarithmic axis where its largest value is at least this many times its smallest."""
LONG_LABEL = 24
"""Most characters in a line of the name of a dimension."""
MANY = 300
"""Runs from which on the marks are small, and a picture in a PDF."""


@styled
def figure_study(table: pd.DataFrame, dimensions: Sequence[Dimension], probe: str = "A", note: str = "") -> Figure:
    """Displacement of the probe and run-out of every run against each dimension of the study, by class; crosses at the lower edge
    diverged.

    ``table`` as from ``sph.study.tables.read_table``.  Points above one another differ in the other dimensions.  Metrics that no
    run has, such as the run-out of a block, are left out.  Raises ValueError for an empty table.
    """
    if table.empty:
        raise ValueError("table: no run to draw")
    metrics = [name for name in SHOWN if table[name].notna().any()] or list(SHOWN)[:1]
    across = min(len(dimensions), COLUMNS)
    down = len(metrics) * -(-len(dimensions) // across)
    figure = Figure(figsize=(WIDTH, 0.6 + 2.1 * down), layout="constrained")
    axes = figure.subplots(down, across, squeeze=False)
    for ax in axes.flat[: down * across]:
        ax.set_visible(False)
    for place, found in enumerate(dimensions):
        for row, name in enumerate(metrics):
            ax = axes[len(metrics) * (place // across) + row, place % across]
            ax.set_visible(True)
            _draw(ax, table, found, name)
            if place % across == 0:
                ax.set_ylabel(SHOWN[name].format(probe=plain(probe)))
            else:
                ax.tick_params(labelleft=False)
            if row == len(metrics) - 1:
                ax.set_xlabel(_wrapped(found.label))
            else:
                ax.tick_params(labelbottom=False)
    handles = [Line2D([], [], label=name, **_look(name, False)) for name in CLASSES if (table["collapse_class"] == name).any()]
    if (table["collapse_class"] == UNDETERMINED).any():
        handles.append(Line2D([], [], label="diverged", **DIVERGED))
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))
    write_note(figure, note)
    return figure


def _wrapped(label: str) -> str:
    """Name of a dimension for an axis: a long one in lines that end with a part of its path."""
    text = "$S_R$" if label == "S_R" else plain(label)
    return "\n".join(line.replace(". ", ".") for line in textwrap.wrap(text.replace(".", ". "), LONG_LABEL))


DIVERGED: dict[str, Any] = {"linestyle": "", "marker": "x", "markersize": 5, "color": "#0072b2", "markeredgewidth": 1.2}


def _look(name: str, many: bool) -> dict[str, Any]:
    number = CLASSES.index(name)
    edge = {"markersize": 2.2, "markeredgewidth": 0.0} if many else {"markersize": 4.2, "markeredgecolor": "black", "markeredgewidth": 0.4}
    return {"linestyle": "", "marker": MARKERS[number], "color": colour_map("lajolla_r")((0.1, 0.3, 0.55, 0.8)[number]), **edge}


def _draw(ax: Axes, table: pd.DataFrame, found: Dimension, metric: str) -> None:
    """One metric against one dimension; words stand side by side in their order."""
    words = list(dict.fromkeys(table[found.name]))
    x = table[found.name].map(words.index) if found.words else table[found.name].astype(float)
    drawn = table["collapse_class"].where(table[metric].notna())
    for name in (name for name in CLASSES if (drawn == name).any()):  # a line without points would upset the layout
        of_class = drawn == name
        ax.plot(x[of_class], table[metric][of_class], rasterized=len(table) > MANY, clip_on=False, **_look(name, len(table) > MANY))
    diverged = table["collapse_class"] == UNDETERMINED
    if diverged.any():
        ax.plot(x[diverged], np.full(diverged.sum(), 0.02), transform=ax.get_xaxis_transform(), **DIVERGED)
    ax.set_ylim(0.0, max(1.06 * float(table[metric].max()), 1e-3) if table[metric].notna().any() else 1.0)
    if found.words:
        ax.set_xticks(range(len(words)), [plain(word) for word in words], rotation=20 if max(map(len, words)) > 8 else 0)
        ax.set_xlim(-0.5, len(words) - 0.5)
    elif x.min() > 0 and x.max() >= LOG_FROM * x.min():
        ax.set_xscale("log")
