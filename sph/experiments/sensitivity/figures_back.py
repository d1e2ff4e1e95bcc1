"""Back-analysis: what was observed, what the surrogate predicts and what the runs gave, over the factors that are sought."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.tri import TriAnalyzer, Triangulation

from sph.experiments.base import metric_label, metric_words
from sph.experiments.sensitivity.back_analysis import BEST, NOT_REACHED, REACHED, Problem
from sph.experiments.sensitivity.factors import Axis, Observation
from sph.experiments.sensitivity.posterior import CONFIDENCE
from sph.figures.style import GREY, WIDTH, colour_map, curve_colours, label_panels, plain, soil_colours, styled, write_note, written
from sph.study.dimensions import shown_unit

REGIONS = (0.5, CONFIDENCE)
"""Shares of the posterior in the regions that are drawn."""
OBSERVED = "firebrick"
BINS = 40


@styled
def figure_back_analysis(
    result: pd.DataFrame, points: pd.DataFrame, confirmed: pd.DataFrame, sample: pd.DataFrame, problem: Problem, note: str = ""
) -> Figure:
    """Of one factor the metrics against it, of two the region that agrees with what was observed, of more the posterior of each.

    ``result``, ``points`` and ``confirmed`` with the columns ``BACK_ANALYSIS``, ``posterior_columns`` and ``confirmed_columns``; ``sample``
    are the runs of the surrogate.
    """
    draw: Callable[..., list[Any]] = _curve if len(problem.sought) == 1 else _map
    if len(problem.sought) > 2:
        return _marginals(result, points, problem, note)
    observations = problem.observations
    figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
    axes = figure.subplots(1, len(observations), squeeze=False)[0]
    handles = list[Any]()
    for ax, seen in zip(axes, observations, strict=True):
        rows = confirmed[confirmed["metric"] == seen.quantity.metric]
        handles = draw(ax, seen, result, points, rows, sample, problem)
    label_panels(axes, [f"{metric_words(seen.quantity.metric)}: {seen.value:g} ± {seen.error:g} {_unit(seen)}" for seen in observations])
    figure.legend(handles=handles, loc="outside upper center", ncols=3)
    write_note(figure, note)
    return figure


def _unit(seen: Observation) -> str:
    return shown_unit(seen.quantity.metric_unit)


def _place(axis: Axis) -> str:
    unit = shown_unit(axis.unit)
    return written(axis.label) + (f" ({unit})" if unit else "")


def _scale(ax: Axes, axis: Axis, which: str) -> None:
    """Bounds, scale and name of a factor's axis."""
    ax.set(**{f"{which}scale": "log" if axis.log else "linear", f"{which}lim": (axis.low, axis.high), f"{which}label": _place(axis)})


def _curve(
    ax: Axes, seen: Observation, result: pd.DataFrame, points: pd.DataFrame, rows: pd.DataFrame, sample: pd.DataFrame, problem: Problem
) -> list[Any]:
    """A metric against the only factor."""
    (axis,), name, colour = problem.sought, seen.quantity.metric, curve_colours(1)[0]
    line = points.sort_values(axis.name)
    ax.fill_between(line[axis.name], line[f"{name}_lower"], line[f"{name}_upper"], color=colour, alpha=0.2, linewidth=0)
    ax.plot(line[axis.name], line[name], color=colour)
    ax.plot(sample[axis.name], sample[name], linestyle="", marker="o", markersize=3, color=GREY)
    ax.axhspan(seen.value - seen.error, seen.value + seen.error, color=OBSERVED, alpha=0.2, linewidth=0)
    ax.axhline(seen.value, color=OBSERVED, linewidth=0.8, linestyle="--")
    ends = result.iloc[0]
    for end in ("lower", "upper"):
        ax.axvline(ends[end], color="black", linewidth=0.8, linestyle=":")
    ax.plot(rows[axis.name], rows["measured"], linestyle="", marker="D", markersize=5, markerfacecolor="white", color="black")
    _scale(ax, axis, "x")
    ax.set(ylabel=metric_label(name))
    return [
        Line2D([], [], color=colour, label=f"surrogate, band of {REACHED:g} standard deviations"),
        Line2D([], [], color=OBSERVED, linewidth=0.8, linestyle="--", label="observed, band of one"),
        Line2D([], [], color="black", linewidth=0.8, linestyle=":", label=f"{CONFIDENCE:.0%} interval"),
        Line2D([], [], linestyle="", marker="o", markersize=3, color=GREY, label=_of_sample(problem)),
        Line2D([], [], linestyle="", marker="D", markersize=5, markerfacecolor="white", color="black", label="runs to confirm it"),
    ]


def _of_sample(problem: Problem) -> str:
    """What the runs of the sample are called: with other factors than those sought they need not lie near the surrogate."""
    return "runs of the sample" + ", other factors vary" * (len(problem.axes) > len(problem.sought))


def _map(
    ax: Axes, seen: Observation, result: pd.DataFrame, points: pd.DataFrame, rows: pd.DataFrame, sample: pd.DataFrame, problem: Problem
) -> list[Any]:
    """The region of two factors that agrees, with the runs."""
    first, second = problem.sought
    name, reached = seen.quantity.metric, result["determined"].iloc[0] != NOT_REACHED
    x, y = (points[axis.name].to_numpy() for axis in (first, second))
    even = Triangulation(first.share(x), second.share(y))
    mesh = Triangulation(x, y, even.triangles, TriAnalyzer(even).get_flat_tri_mask(0.05))
    shades = [colour_map("lajolla_r")(at) for at in (0.35, 0.12)]
    if reached:
        ax.tricontourf(mesh, points["mass"], levels=[0.0, *REGIONS], colors=shades)
    ax.tricontour(mesh, points[name], levels=[seen.value], colors=OBSERVED, linewidths=1.0)
    dots = ax.scatter(
        sample[first.name],
        sample[second.name],
        c=sample[name],
        s=14,
        clip_on=False,
        cmap=soil_colours(),
        edgecolors="white",
        linewidths=0.3,
    )
    bar = ax.figure.colorbar(dots, ax=ax, pad=0.02)
    bar.set_label(f"{metric_words(name)} of the runs ({_unit(seen)})")
    bar.outline.set_visible(False)
    best = rows[rows["run"] == BEST]
    others = rows[rows["run"] != BEST]
    looks: dict[str, Any] = {"linestyle": "", "markerfacecolor": "white", "color": "black", "clip_on": False}
    ax.plot(others[first.name], others[second.name], marker="D", markersize=5, **looks)
    ax.plot(best[first.name], best[second.name], marker="*", markersize=10, **looks)
    _scale(ax, first, "x")
    _scale(ax, second, "y")
    shown = [Patch(color=colour, label=f"{share:.0%} region") for share, colour in zip(REGIONS, shades, strict=True)] if reached else []
    return [
        *shown,
        Line2D([], [], color=OBSERVED, linewidth=1.0, label="surrogate: observed value"),
        Line2D([], [], marker="o", markersize=4, linestyle="", color=GREY, label=_of_sample(problem)),
        Line2D([], [], marker="*", markersize=10, label="run at the best point" if reached else "run at the nearest point", **looks),
        Line2D([], [], marker="D", markersize=5, label="runs at the ends of the intervals", **looks),
    ][: None if reached else -1]


def _marginals(result: pd.DataFrame, points: pd.DataFrame, problem: Problem, note: str) -> Figure:
    """The posterior of every factor, whatever the others."""
    columns = min(len(problem.sought), 4)
    lines = -(-len(problem.sought) // columns)
    figure = Figure(figsize=(WIDTH, 2.3 * lines + 0.4), layout="constrained")
    grid = figure.subplots(lines, columns, squeeze=False).ravel()
    colour, rows = curve_colours(1)[0], result.set_index("factor")
    for ax, axis in zip(grid, problem.sought, strict=False):
        edges = np.array([axis.value(share) for share in np.linspace(0.0, 1.0, BINS + 1)])
        heights, _ = np.histogram(points[axis.name], edges, weights=points["weight"])
        ax.stairs(heights * BINS, edges, fill=True, color=colour, alpha=0.4)
        ax.axhline(1.0, color=GREY, linewidth=0.8)
        for end in ("lower", "upper"):
            ax.axvline(rows.loc[axis.name, end], color="black", linewidth=0.8, linestyle=":")
        ax.plot(
            rows.loc[axis.name, BEST], 0.0, marker="*", markersize=10, markerfacecolor="white", color="black", clip_on=False, linestyle=""
        )
        _scale(ax, axis, "x")
        ax.set_ylim(bottom=0.0)
    for ax in grid[len(problem.sought) :]:
        ax.set_visible(False)
    grid[0].set_ylabel("posterior over prior density")
    label_panels(grid[: len(problem.sought)], [written(axis.label) for axis in problem.sought])
    handles = [
        Patch(color=colour, alpha=0.4, label="posterior"),
        Line2D([], [], color=GREY, linewidth=0.8, label="prior"),
        Line2D([], [], color="black", linewidth=0.8, linestyle=":", label=f"{CONFIDENCE:.0%} interval"),
        Line2D([], [], linestyle="", marker="*", markersize=10, markerfacecolor="white", color="black", label="best point"),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    write_note(figure, plain(f"{note} · {problem.seen}"))
    return figure
