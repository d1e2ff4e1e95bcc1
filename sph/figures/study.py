"""All runs of a study, of any dimensions: results as curves against one of them, and as maps of two."""

from __future__ import annotations

import itertools
import math
import textwrap
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from sph.checks.after_run import at_least, is_at_least
from sph.figures.style import GREY, LEAST, LINE_STYLES, WIDTH, class_colours, curve_colours, metres, plain, styled, write_note, written
from sph.measures.metrics import CLASSES, UNDETERMINED
from sph.storage.trajectory import Status
from sph.study.dimensions import Dimension, title_of

SHOWN = {"displacement_magnitude": "displacement of {probe} (m)", "runout": "run-out (m)"}
"""The metrics that are drawn, and their words."""
MARKERS = dict(zip(CLASSES, "osDP", strict=True))
"""Classes differ by these as well as by colour."""
COLUMNS = 3
"""Most panels side by side."""
MAX_TICKS = 5
"""Most accelerations that an axis names one by one, in m/s2 and g."""
MAX_PANELS = 9
"""Most panels into which a grid is split; of a larger one every run is drawn against each dimension instead."""
NUMBERED = 15
"""Most cells of a map side by side that have room for their numbers."""
LOG_FROM = 50.0
"""A dimension is drawn on a logarithmic axis where its largest value is at least this many times its smallest."""
LONG_LABEL = 28
"""Most characters in a line of the name of a dimension or of a panel."""
LONG_NAME = 16
"""Most characters in a line of the name of a record."""
MANY = 300
"""Runs from which on the marks are small, and a picture in a PDF."""
DIVERGED: dict[str, Any] = {"linestyle": "", "marker": "x", "markersize": 5, "color": "#0072b2", "markeredgewidth": 1.2}
BOUNDED: dict[str, Any] = {"linestyle": "", "marker": "$\\uparrow$", "markersize": 10, "color": "#0072b2", "markeredgewidth": 0.3}
"""Over the mark of a run whose debris met the box, was braked or still moves: its value is a lower bound."""

HATCH = "///"
"""Of cells whose soil fails before the shaking."""
UNSHAKEN = "fails without shaking"
"""The mark of such runs, in words."""


class Panel(NamedTuple):
    """What is drawn in a panel, and against what."""

    title: str
    along: Dimension
    runs: pd.DataFrame


class Arrangement(NamedTuple):
    """How the runs of a study are drawn."""

    panels: list[Panel]
    other: Dimension | None  # of the curves, or of the other axis of a map
    grid: bool


def arranged(table: pd.DataFrame, dimensions: Sequence[Dimension], most: int) -> Arrangement:
    """The panels of a study: of a grid along one dimension, the shaking or else the first of numbers, with the other one of at most
    ``most`` values, and a panel per value of the rest; of anything else a panel per dimension.  ValueError for an empty table."""
    if table.empty:
        raise ValueError("table: no run to draw")
    names = [dimension.name for dimension in dimensions]
    values = {dimension: list(dict.fromkeys(table[dimension.name])) for dimension in dimensions}
    varied = [dimension for dimension in dimensions if len(values[dimension]) > 1] or list(dimensions[:1])
    along = min(varied, key=lambda dimension: (dimension.named, dimension.name != "amplitude"))
    rest = [dimension for dimension in varied if dimension != along]
    other = max(
        (dimension for dimension in rest if len(values[dimension]) <= most), key=lambda dimension: len(values[dimension]), default=None
    )
    split = [dimension for dimension in rest if dimension != other]
    is_grid = not table.duplicated(names).any() and math.prod(map(len, values.values())) == len(table)
    if not is_grid or math.prod(len(values[dimension]) for dimension in split) > MAX_PANELS:
        return Arrangement([Panel("", dimension, table) for dimension in dimensions], None, False)
    panels = []
    for point in itertools.product(*(values[dimension] for dimension in split)):
        at = dict(zip((dimension.name for dimension in split), point, strict=True))
        of_panel = np.logical_and.reduce([table[name] == value for name, value in at.items()], initial=True)
        panels.append(Panel(title_of(split, at), along, table[np.broadcast_to(of_panel, len(table))]))
    return Arrangement(panels, other, True)


@styled
def figure_study(table: pd.DataFrame, dimensions: Sequence[Dimension], probe: str = "A", note: str = "") -> Figure:
    """Displacement of the probe and run-out of every run.  A grid is drawn against the amplitude of shaking, or else its first dimension,
    with a curve for every value of another and panels for the rest; between words, such as records, a curve only shows which runs belong
    together.  A list or a sample is drawn against each of its dimensions.  Marks show the class; crosses at the lower edge are runs that
    diverged, hollow marks runs that failed before the shaking, arrows lower bounds: debris met the end of the box, was braked or still
    moves.

    ``table`` as from ``sph.study.tables.read_table``.  Metrics that no run has, such as the run-out of a block, are left out.  Raises
    ValueError for an empty table.
    """
    arrangement = arranged(table, dimensions, len(LINE_STYLES))
    values = [] if arrangement.other is None else list(dict.fromkeys(table[arrangement.other.name]))
    looks = [{"color": colour, "linestyle": line} for colour, line in zip(curve_colours(len(values)), LINE_STYLES, strict=False)]
    metrics = [name for name in SHOWN if table[name].notna().any()] or list(SHOWN)[:1]
    figure = Figure(layout="constrained")
    for panel, metric, ax in _axes(figure, arrangement.panels, metrics, 2.1):
        at = _places(ax, "x", panel.along, table)
        runs = panel.runs.assign(x=panel.runs[panel.along.name].map(at), y=panel.runs[metric])
        curves = (
            [(runs, {"color": GREY, "linestyle": "-"})]
            if arrangement.other is None
            else [(runs[runs[arrangement.other.name] == value], look) for value, look in zip(values, looks, strict=True)]
        )
        for rows, look in curves if arrangement.grid and (arrangement.other or not panel.along.named) else ():
            ax.plot(rows["x"], rows["y"], linewidth=1.0, zorder=1, **look)
        _draw_runs(ax, runs)
        largest = float(table[metric].max())
        ax.set_ylim(0.0, 1.06 * largest if largest >= LEAST else 1.0)  # no scale of less than a spacing resolves
        ax.set_ylabel(SHOWN[metric].format(probe=plain(probe)))
    if arrangement.other is not None:
        named = [plain(arrangement.other.shown(value)) for value in values]
        handles = [Line2D([], [], label=name, **look) for name, look in zip(named, looks, strict=True)]
        figure.legend(
            handles=handles, loc="outside upper left", ncols=len(handles), title=_wrapped(arrangement.other.label), handlelength=3.0
        )
    _class_legend(figure, table)
    write_note(figure, note)
    return figure


@styled
def figure_map(table: pd.DataFrame, dimensions: Sequence[Dimension], probe: str = "A", note: str = "") -> Figure:
    """Class of every run over two dimensions, with panels for the rest; of a list or a sample, over its first two.  The number in a cell
    is the displacement of the probe in m; crosses are runs that diverged, hatched cells runs that failed before the shaking.  Nothing is
    interpolated.

    ``table`` as from ``sph.study.tables.read_table``.  Raises ValueError for an empty table.
    """
    arrangement = arranged(table, dimensions, len(table))
    if not arrangement.grid:
        arrangement = Arrangement([Panel("", dimensions[0], table)], (*dimensions[1:], None)[0], False)
    rows = 1 if arrangement.other is None else min(table[arrangement.other.name].nunique(), 8)
    figure = Figure(layout="constrained")
    for panel, _, ax in _axes(figure, arrangement.panels, [""], 1.0 + 0.25 * rows if arrangement.grid else 3.0):
        at = [
            {"": 0.0} if each is None else _places(ax, axis, each, table, arrangement.grid)
            for axis, each in (("x", panel.along), ("y", arrangement.other))
        ]
        x = panel.runs[panel.along.name].map(at[0])
        y = pd.Series(0.0, x.index) if arrangement.other is None else panel.runs[arrangement.other.name].map(at[1])
        if arrangement.grid:
            _draw_cells(ax, panel.runs.assign(x=x, y=y), len(at[0]) * min(len(arrangement.panels), COLUMNS) <= NUMBERED)
        else:
            _draw_runs(ax, panel.runs.assign(x=x, y=y))
        if arrangement.other is None:
            ax.set(yticks=[], ylim=(-0.5, 0.5))
    _class_legend(figure, table, arrangement.grid)
    if arrangement.grid:
        figure.text(0.005, 0.995, f"numbers: displacement of {plain(probe)} (m)", ha="left", va="top")
    write_note(figure, note)
    return figure


def _axes(figure: Figure, panels: Sequence[Panel], metrics: Sequence[str], height: float) -> Iterator[tuple[Panel, str, Axes]]:
    """Axes for every panel and metric, a panel's below one another; labels where the left ones and the lowest do not tell."""
    across = 2 if len(panels) == 4 else min(len(panels), COLUMNS)
    down = len(metrics) * -(-len(panels) // across)
    figure.set_size_inches(WIDTH, 0.9 + height * down)
    axes = figure.subplots(down, across, squeeze=False)
    for ax in axes.flat:
        ax.set_visible(False)
    for place, panel in enumerate(panels):
        for row, metric in enumerate(metrics):
            ax = axes[len(metrics) * (place // across) + row, place % across]
            ax.set_visible(True)
            yield panel, metric, ax
            if row == 0:
                ax.set_title(_wrapped(panel.title), loc="left")
            if row < len(metrics) - 1:
                ax.tick_params(labelbottom=False)
                ax.set_xlabel("")
            if place % across:
                ax.tick_params(labelleft=False)
                ax.set_ylabel("")


def _places(ax: Axes, axis: str, dimension: Dimension, table: pd.DataFrame, cells: bool = False) -> dict[str, float]:
    """Places of a dimension's values along an axis, which gets its name: words and ``cells`` stand side by side in their order."""
    words = list(dict.fromkeys(table[dimension.name]))
    ax.set(**{f"{axis}label": _wrapped(dimension.label)})
    labels = [plain(dimension.shown(word)).replace(" (", "\n(") for word in words]
    if dimension.names:
        labels = [textwrap.fill(label, LONG_NAME) for label in labels]
    if cells or dimension.named:
        longest = max(len(line) for label in labels for line in label.split("\n"))
        getattr(ax, f"set_{axis}ticks")(range(len(words)), labels, rotation=20 if axis == "x" and longest > 8 else 0)
        getattr(ax, f"set_{axis}lim")(-0.5, len(words) - 0.5)
        return dict(zip(words, map(float, range(len(words))), strict=True))
    at = {word: float(word) for word in words}
    if labels != words and len(words) <= MAX_TICKS:
        getattr(ax, f"set_{axis}ticks")(list(at.values()), labels)
    if min(at.values()) > 0 and max(at.values()) >= LOG_FROM * min(at.values()):
        getattr(ax, f"set_{axis}scale")("log")
    return at


def _draw_runs(ax: Axes, runs: pd.DataFrame) -> None:
    """Marks at the runs' ``x`` and ``y``, by class; hollow where soil fails before the shaking."""
    many = len(runs) > MANY
    for name, unshaken in itertools.product(CLASSES, (False, True)):
        rows = runs[(runs["collapse_class"] == name) & runs["y"].notna() & ((runs["status"] == Status.FAILED_UNSHAKEN) == unshaken)]
        if len(rows):  # a line without points would upset the layout
            hollow = {"markerfacecolor": "white"} if unshaken else {}
            ax.plot(rows["x"], rows["y"], rasterized=many, clip_on=False, **_look(name, many) | hollow)
    bounded = runs[at_least(runs) & runs["y"].notna()]
    if len(bounded):
        ax.plot(bounded["x"], bounded["y"], clip_on=False, **BOUNDED)
    diverged = runs[runs["collapse_class"] == UNDETERMINED]
    if len(diverged):
        ax.plot(diverged["x"], np.full(len(diverged), 0.02), transform=ax.get_xaxis_transform(), **DIVERGED)


def _draw_cells(ax: Axes, runs: pd.DataFrame, numbered: bool) -> None:
    """A cell per run at ``x`` and ``y``, by class."""
    colours = dict(zip(CLASSES, class_colours(), strict=True))
    for run in runs.to_dict("records"):
        colour = colours.get(run["collapse_class"], "white")
        hatch = HATCH if run["status"] == Status.FAILED_UNSHAKEN else None
        ax.add_patch(Rectangle((run["x"] - 0.5, run["y"] - 0.5), 1.0, 1.0, facecolor=colour, edgecolor="white", linewidth=0.8, hatch=hatch))
        if run["collapse_class"] == UNDETERMINED:
            ax.plot(run["x"], run["y"], **DIVERGED)
        elif numbered:
            dark = float(np.dot(to_rgb(colour), (0.3, 0.59, 0.11))) < 0.5
            ax.text(
                run["x"],
                run["y"],
                metres(run["displacement_magnitude"], is_at_least(run)),
                ha="center",
                va="center",
                color="white" if dark else "black",
                bbox={"facecolor": colour, "edgecolor": "none", "pad": 1.5},
            )


def _class_legend(figure: Figure, table: pd.DataFrame, cells: bool = False) -> None:
    """The classes that there are, and what marks a run that diverged or failed before the shaking where there is one."""
    reached = [(name, colour) for name, colour in zip(CLASSES, class_colours(), strict=True) if (table["collapse_class"] == name).any()]
    handles = [
        Patch(facecolor=colour, edgecolor=GREY, linewidth=0.4, label=name) if cells else Line2D([], [], label=name, **_look(name, False))
        for name, colour in reached
    ]
    diverged = [Line2D([], [], label="diverged", **DIVERGED)] if (table["collapse_class"] == UNDETERMINED).any() else []
    hollow = {**_look(CLASSES[0], False), "markerfacecolor": "white"}
    mark = Patch(facecolor="white", edgecolor=GREY, hatch=HATCH, label=UNSHAKEN) if cells else Line2D([], [], label=UNSHAKEN, **hollow)
    arrows = not cells and at_least(table).any()
    bounded = [Line2D([], [], label="lower bound", **BOUNDED)] if arrows else []
    unshaken = [mark] if (table["status"] == Status.FAILED_UNSHAKEN).any() else []
    figure.legend(handles=[*handles, *diverged, *unshaken, *bounded], loc="outside upper right", ncols=4)


def _wrapped(label: str) -> str:
    """Name of a dimension or a panel, a long one in lines."""
    return "\n".join(textwrap.wrap(written(label), LONG_LABEL))


def _look(name: str, many: bool) -> dict[str, Any]:
    edge = {"markersize": 2.2, "markeredgewidth": 0.0} if many else {"markersize": 4.2, "markeredgecolor": "black", "markeredgewidth": 0.4}
    return {"linestyle": "", "marker": MARKERS[name], "color": class_colours()[CLASSES.index(name)], **edge}
