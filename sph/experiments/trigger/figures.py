"""Critical intensities, maps over a dimension and the intensity, shares of the values searched that reach a class."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import Any

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from sph.experiments.base import metric_label
from sph.experiments.trigger.critical import AT_LOWEST, BRACKETED, BRAKED, NEVER
from sph.experiments.trigger.design import Searched
from sph.figures.style import (
    GREY,
    LINE_STYLES,
    WIDTH,
    also_in_g,
    class_colours,
    colour_map,
    curve_colours,
    label_panels,
    plain,
    styled,
    write_note,
    written,
)
from sph.measures.metrics import CLASSES, UNDETERMINED
from sph.study.dimensions import Dimension, is_number

MARKERS = "osD^v<>p"
MAX_LETTERS = 72
"""Most characters of the titles of panels side by side, together."""
MAX_UPRIGHT = 36
"""Most characters of a line beside an axis."""
GRID_POINTS = 241
"""Points along each side of a map's background."""


MAPPED = {"displacement": "displacement_magnitude", "runout": "runout", "failed": "failed_fraction"}
"""The metrics that are mapped, by the names in files."""


def _words(dimension: Dimension, value: str) -> str:
    """A dimension and one of its values."""
    return written(dimension.equation(value))


def _axis(dimension: Dimension) -> str:
    """Name of an axis."""
    return written(dimension.phrase if dimension.name == "S_R" else dimension.label)


def _at(table: pd.DataFrame, dimensions: Sequence[Dimension]) -> pd.Series:
    """What every row is at, in words: the values of some dimensions."""
    return table.apply(lambda row: ", ".join(_words(dimension, row[dimension.name]) for dimension in dimensions), axis=1)


def _across(table: pd.DataFrame, others: Sequence[Dimension]) -> tuple[Dimension | None, list[Dimension]]:
    """The dimension along the horizontal axis, the first of numbers if there is one, and the rest."""
    x = next((each for each in others if table[each.name].map(is_number).all()), None)
    return x, [each for each in others if each != x]


@styled
def figure_critical(table: pd.DataFrame, searched: Searched, note: str = "") -> Figure:
    """Critical intensity against the first other numeric dimension: a curve per value of the rest, a row per class, a column per case;
    against the cases where that dimension has one value.

    ``table`` as from ``read_critical``; bars are the brackets.  An arrow stands where there is no bracket: down, the class is reached at
    the lowest intensity; up, it is not reached at the highest.  Raises ValueError for an empty table.
    """
    if table.empty:
        raise ValueError("table: no row to draw")
    across, rest = _across(table, searched.others)
    cases, classes = (list(dict.fromkeys(table[name])) for name in ("case", "collapse_class"))
    by_case = len(cases) > 1 and (across is None or table[across.name].nunique() == 1)
    if by_case:
        across, rest = None, list(searched.others)
    unordered = by_case or across is not None and across.name.endswith("seed")
    x = table["case"].map(cases.index).astype(float) if by_case else table[across.name].astype(float) if across else 0.0
    table = table.assign(curve=_at(table, rest), x=x)
    columns = [cases] if by_case else [[case] for case in cases]
    curves = list(dict.fromkeys(table["curve"]))
    looks = [dict(color=colour, marker=MARKERS[number % len(MARKERS)]) for number, colour in enumerate(curve_colours(len(curves)))]
    figure = Figure(figsize=(WIDTH, 0.7 + 2.3 * len(classes)), layout="constrained")
    axes = figure.subplots(len(classes), len(columns), sharex=True, sharey=True, squeeze=False)
    titles = []
    for ax, (name, shown) in zip(axes.flat, itertools.product(classes, columns), strict=True):
        rows = table[(table["collapse_class"] == name) & table["case"].isin(shown)]
        for look, curve in zip(looks, curves, strict=True):
            _draw_brackets(ax, rows[rows["curve"] == curve], look | ({"linestyle": ""} if unordered else {}))
        for column, style in zip(_estimates(searched), LINE_STYLES[1:], strict=False):
            for case in shown:
                _draw_estimate(ax, rows[rows["case"] == case], column, by_case, color=GREY, linewidth=1.0, linestyle=style, zorder=1)
        titles.append(name if by_case else f"{name}: {plain(case)}")
    label_panels(axes.flat, titles)
    axes[0, 0].set_ylim(0.0, None)
    for ax in axes[-1]:
        if by_case:
            ax.set_xticks(range(len(cases)), [plain(case) for case in cases], rotation=20 if max(map(len, cases)) > 8 else 0)
        else:
            ax.set(xlabel=_axis(across)) if across else ax.set(xticks=[])
    for ax in axes[:, 0]:
        ax.set_ylabel(plain(f"critical {searched.intensity.label}"))
    _add_g(axes[:, -1], searched)
    handles = [Line2D([], [], markersize=4, label=curve, **look) for look, curve in zip(looks, curves, strict=True) if curve]
    handles += [
        Line2D([], [], color=GREY, linewidth=1.0, linestyle=style, label=label)
        for (column, label), style in zip(_estimates(searched).items(), LINE_STYLES[1:], strict=False)
        if table[column].notna().any()
    ]
    handles += [Line2D([], [], linestyle="", color=GREY, label=words, **look) for where, _, look, words in _marked(table) if where.any()]
    if handles:
        figure.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 3), handlelength=3.0)
    write_note(figure, note)
    return figure


def _add_g(axes: Iterable[Axes], searched: Searched) -> None:
    """A scale in g at the right of panels with the intensity upwards, where that is an acceleration."""
    for ax in axes:
        if searched.intensity.unit == "m/s2":
            also_in_g(ax, "y")


def _estimates(searched: Searched) -> dict[str, str]:
    """Columns of the horizontal lines, and their names; an acceleration is drawn where the intensity is one."""
    static = {"yield_acceleration": "pseudo-static"} if searched.intensity.unit == "m/s2" else {}
    return {**static, "newmark_intensity": "sliding block (Newmark)"}


def _draw_estimate(ax: Axes, rows: pd.DataFrame, column: str, by_case: bool, **look: Any) -> None:
    """An estimate of a case: from end to end of the panel, or of the case, where it is one; else along its curves."""
    if rows["x"].nunique() == 1 or rows[column].nunique() <= 1:
        ends = (rows["x"].iloc[0] - 0.4, rows["x"].iloc[0] + 0.4) if by_case else (0.0, 1.0)
        transform = ax.transData if by_case else ax.get_yaxis_transform()
        ax.hlines(rows[column].unique(), *ends, transform=transform, **look)
        return
    for _, curve in rows.groupby("curve"):
        curve = curve.sort_values("x")
        ax.plot(curve["x"], curve[column], **look)


def _draw_brackets(ax: Axes, rows: pd.DataFrame, look: dict[str, Any]) -> None:
    rows = rows.sort_values("x")
    bracketed = rows[rows["outcome"] == BRACKETED]
    error = bracketed["resolution_error"].to_numpy()
    ax.errorbar(bracketed["x"], bracketed["critical_intensity"], yerr=error, markersize=4, capsize=2, elinewidth=0.8, linewidth=1.0, **look)
    for where, column, look_of_mark, _ in _marked(rows):
        _draw_marks(ax, rows[where], column, **look_of_mark, color=look["color"])


def _marked(rows: pd.DataFrame) -> list[tuple[pd.Series, str, dict[str, Any], str]]:
    """What a bracket does not show: the rows that it concerns, the column of their heights, the mark and its words."""
    doubtful = (rows["outcome"] == BRACKETED) & ((rows["changes"] > 1) | (rows["diverged_inside"] > 0))
    marks = [
        (rows["outcome"] == AT_LOWEST, "upper", "v", 7, "at or below the lowest tried"),
        ((rows["outcome"] == BRAKED) & rows["upper"].notna(), "upper", "v", 7, "at or below: debris is braked there"),
        (rows["outcome"] == NEVER, "lower", "^", 7, "above the highest tried"),
        (doubtful, "critical_intensity", "o", 10, "uncertain bracket"),
    ]
    return [
        (where, column, {"marker": marker, "markersize": size, "markerfacecolor": "none"}, words)
        for where, column, marker, size, words in marks
    ]


@styled
def figure_class_map(points: pd.DataFrame, searched: Searched, note: str = "") -> Figure:
    """Class over a dimension and the intensity, a column per value of the rest and a row per case; dots are the points that were run,
    crosses those that diverged.

    ``points`` as from ``read_points``.  Between the points the ground has the class nearest to the interpolated rank.  Raises
    ValueError for an empty table.
    """
    colours = class_colours()
    norm = BoundaryNorm(np.arange(len(CLASSES) + 1) - 0.5, len(CLASSES))
    figure, panels = _panels(points, searched)
    for ax, plane in panels:
        known = plane[plane["collapse_class"] != UNDETERMINED]
        values = known["collapse_class"].map(CLASSES.index).to_numpy(dtype=float)
        _draw_ground(ax, known, values, cmap=ListedColormap(colours), norm=norm)
        _draw_points(ax, plane)
    shades = [Patch(facecolor=colour, edgecolor=GREY, linewidth=0.4, label=name) for colour, name in zip(colours, CLASSES, strict=True)]
    handles = [*shades, *_point_handles(points)]
    figure.legend(handles=handles, loc="outside upper center", ncols=6 if len(handles) <= 6 else 4)
    write_note(figure, note)
    return figure


@styled
def figure_map(points: pd.DataFrame, searched: Searched, metric: str, note: str = "") -> Figure:
    """A metric over a dimension and the intensity, a column per value of the rest and a row per case, linear between the points.

    ``points`` as from ``read_points``, drawn as dots; crosses diverged.  Raises ValueError for an empty table.
    """
    figure, panels = _panels(points, searched)
    highest = float(np.nanmax(points[metric].to_numpy(), initial=0.0)) or 1.0
    for ax, plane in panels:
        known = plane[plane[metric].notna()]
        ground = _draw_ground(ax, known, known[metric].to_numpy(), cmap=colour_map("lajolla_r"), vmin=0.0, vmax=highest)
        _draw_points(ax, plane)
    figure.colorbar(ground, ax=[ax for ax, _ in panels], label=metric_label(metric), pad=0.02, aspect=30)
    figure.legend(handles=_point_handles(points), loc="outside upper center", ncols=3)
    write_note(figure, note)
    return figure


def _panels(points: pd.DataFrame, searched: Searched) -> tuple[Figure, list[tuple[Axes, pd.DataFrame]]]:
    """A panel per case and value of the dimensions beside the first on the undivided lattice, and the points in its plane."""
    if points.empty:
        raise ValueError("points: no point to draw")
    across, *rest = searched.others
    points = points.assign(x=points[across.name].astype(float), y=points[searched.intensity_name].astype(float), plane=_at(points, rest))
    cases = list(dict.fromkeys(points["case"]))
    undivided = points[points["round"] == 0].sort_values([each.name for each in rest], key=lambda column: column.astype(float))
    planes = list(dict.fromkeys(undivided["plane"]))
    figure = Figure(figsize=(WIDTH, 0.7 + 2.4 * len(cases)), layout="constrained")
    axes = figure.subplots(len(cases), len(planes), sharex=True, sharey=True, squeeze=False)
    pairs = [(case, plane) for case in cases for plane in planes]
    titles = [", ".join([plane] * bool(plane) + [plain(case)] * (len(cases) > 1)) for case, plane in pairs]
    label_panels(axes.flat, titles, max(16, MAX_LETTERS // len(planes)))
    for ax in axes[-1]:
        ax.set_xlabel(_axis(across))
    for ax in axes[:, 0]:
        ax.set_ylabel(plain(searched.intensity.label))
    _add_g(axes[:, -1], searched)
    shown = [points[(points["case"] == case) & (points["plane"] == plane)] for case, plane in pairs]
    return figure, list(zip(axes.flat, shown, strict=True))


def _draw_ground(ax: Axes, plane: pd.DataFrame, values: np.ndarray, **look: Any) -> Any:
    """Values at points, linear between them, as a picture of their plane, distances by the plane's sides."""
    ends = [(float(plane[name].min()), float(plane[name].max())) for name in ("x", "y")]
    scaled = np.column_stack([(plane[name] - low) / (high - low) for name, (low, high) in zip("xy", ends, strict=True)])
    at = np.linspace(0.0, 1.0, GRID_POINTS)
    picture = scipy.interpolate.LinearNDInterpolator(scaled, values)(*np.meshgrid(at, at))
    return ax.imshow(picture, origin="lower", extent=(*ends[0], *ends[1]), aspect="auto", interpolation="nearest", **look)


def _draw_points(ax: Axes, plane: pd.DataFrame) -> None:
    diverged, moving = plane["collapse_class"] == UNDETERMINED, plane["still_moving"] == 1
    _draw_marks(ax, plane[~diverged & ~moving], "y", **RUN_LOOK)
    _draw_marks(ax, plane[~diverged & moving], "y", **MOVING_LOOK)
    _draw_marks(ax, plane[diverged], "y", **DIVERGED_LOOK)


def _draw_marks(ax: Axes, rows: pd.DataFrame, column: str, **look: Any) -> None:
    """Marks that may lie on the frame; a line without points would upset the layout."""
    if len(rows):
        ax.plot(rows["x"], rows[column], clip_on=False, **{"linestyle": "", **look})


RUN_LOOK: dict[str, Any] = {
    "linestyle": "",
    "marker": "o",
    "markersize": 2.4,
    "color": "black",
    "markeredgecolor": "white",
    "markeredgewidth": 0.4,
}
MOVING_LOOK: dict[str, Any] = RUN_LOOK | {"marker": "^", "markersize": 4.5}
DIVERGED_LOOK: dict[str, Any] = {"linestyle": "", "marker": "x", "markersize": 6, "color": "#0072b2", "markeredgewidth": 1.6}


def _point_handles(points: pd.DataFrame) -> list[Line2D]:
    handles = [Line2D([], [], label="run", **RUN_LOOK)]
    if ((points["still_moving"] == 1) & (points["collapse_class"] != UNDETERMINED)).any():
        handles.append(Line2D([], [], label="still moving: at least so far", **MOVING_LOOK))
    if (points["collapse_class"] == UNDETERMINED).any():
        handles.append(Line2D([], [], label="diverged", **DIVERGED_LOOK))
    return handles


@styled
def figure_shares(shares: pd.DataFrame, searched: Searched, note: str = "") -> Figure:
    """Share of the values searched with which a class, or a worse one, is reached, against the intensity, a panel per class.

    ``shares`` as from ``read_shares``.  A band lies between the lower and the upper bound that the points leave.  It is a share of values
    of parameters, not a probability of a ground motion.  Raises ValueError for an empty table.
    """
    if shares.empty:
        raise ValueError("shares: no row to draw")
    cases = list(dict.fromkeys(shares["case"]))
    looks = list(zip(cases, curve_colours(len(cases)), itertools.cycle(LINE_STYLES)))
    figure = Figure(figsize=(WIDTH, 2.7), layout="constrained")
    axes = figure.subplots(1, len(CLASSES) - 1, sharey=True)
    for ax, name in zip(axes, CLASSES[1:], strict=True):
        for case, colour, line in looks:
            rows = shares[(shares["case"] == case) & (shares["collapse_class"] == name)]
            at = np.append(rows[f"{searched.intensity_name}_lower"], rows[f"{searched.intensity_name}_upper"].iloc[-1])
            low, high = (np.append(rows[end], rows[end].iloc[-1]) for end in ("share_lower", "share_upper"))
            ax.fill_between(at, low, high, step="post", color=colour, alpha=0.25, linewidth=0)
            for bound in (low, high):
                ax.step(at, bound, where="post", color=colour, linestyle=line, linewidth=1.0)
        ax.set(xlabel=plain(searched.intensity.label), xlim=(at[0], at[-1]), ylim=(0.0, 1.02))
    over = f"share of the values of {' and '.join(each.symbol for each in searched.others)} searched"
    axes[0].set_ylabel("\n".join(written(line) for line in wrap(over, MAX_UPRIGHT)))
    label_panels(axes, [f"at least {name}" if name != CLASSES[-1] else name for name in CLASSES[1:]])
    handles = [
        Patch(facecolor=(*colour[:3], 0.25), edgecolor=colour, linestyle=line, label=f"{plain(case)}: between the bounds")
        for case, colour, line in looks
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=2)
    write_note(figure, note)
    return figure
