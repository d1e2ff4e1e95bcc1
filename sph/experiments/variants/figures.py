"""The cost-accuracy study: error against cost, and results against spacing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from sph.experiments.base import metric_label
from sph.experiments.variants.schema import FIDELITY
from sph.experiments.variants.table import QUANTITIES, WORDS, Summary, non_dominated, summary
from sph.figures.style import GREY, LINE_STYLES, WIDTH, curve_colours, label_panels, styled, write_note, written

MARKERS = "osD^v<>ph8PXdH*"
"""Markers of the parameters, beside their colours."""
MIN_ERROR = 1e-3
"""Errors below this are drawn at it: a logarithmic axis has no zero."""
HALO = withStroke(linewidth=2.0, foreground="white")
"""Keeps a name readable over marks."""
ONSET = {"onset_after_start": "onset of A (s of shaking)"}
"""Label of what is no metric of a run."""


@styled
def figure_tradeoff(table: pd.DataFrame) -> Figure:
    """Error of A's displacement and of the run-out against computing time, a point per variant; hollow where the class differs in a case.

    ``table`` as from ``read_cost_accuracy``.  The error is the largest deviation from the reference over the cases, the time that of the
    timed case; the line joins the variants that no other of the reference's class beats in both.  The reference, variants that were not
    run in every case and diverged ones have no point.  Raises ValueError where nothing is left to draw.
    """
    variants = summary(table)
    shown = [variant for variant in variants if variant.every_case and variant.finished and not variant.reference]
    if not shown:
        raise ValueError("table: no variant but the reference was run to its end in every case, so there is nothing to draw")
    parameters = list(dict.fromkeys(variant.parameter for variant in shown))
    colours = curve_colours(len(parameters))
    looks = {parameter: (colours[at], MARKERS[at % len(MARKERS)]) for at, parameter in enumerate(parameters)}
    figure = Figure(figsize=(WIDTH, 3.9), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    for ax, name in zip(axes, QUANTITIES, strict=True):
        _draw_errors(ax, shown, name, looks)
    axes[0].set_ylabel("largest deviation from the reference")
    axes[0].yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %"))
    label_panels(axes, [WORDS[name] for name in QUANTITIES])
    point: dict[str, Any] = {"xdata": [], "ydata": [], "linestyle": ""}
    handles = [Line2D(**point, marker=mark, color=colour, label=parameter.replace("_", " ")) for parameter, (colour, mark) in looks.items()]
    handles.append(Line2D(**point, marker="o", color=GREY, markerfacecolor="white", label="class differs from the reference's"))
    handles.append(Line2D([], [], color=GREY, linewidth=1.0, label="least error for the time"))
    figure.legend(handles=handles, loc="outside upper center", ncols=4, handletextpad=0.2)
    reference = next(variant for variant in variants if variant.reference)
    where = f"reference {reference.name}, {reference.cost:.4g} s"
    write_note(figure, f"{where} · one core of {table['machine'].iloc[0]}, runs side by side")
    return figure


def _draw_errors(ax: Axes, variants: Sequence[Summary], name: str, looks: Mapping[str, tuple[Any, str]]) -> None:
    cost = np.array([variant.cost for variant in variants])
    error = np.maximum([variant.errors[name] for variant in variants], MIN_ERROR)
    agrees = np.array([variant.classes_agree == variant.cases for variant in variants])
    # The front is that of what 'sph advise' may answer.
    sound = agrees & np.array([variant.sound for variant in variants])
    front = non_dominated(cost, np.where(sound, error, np.nan))
    ax.plot(cost[front], error[front], color=GREY, linewidth=1.0, drawstyle="steps-post", zorder=1)
    for variant, x, y, good in zip(variants, cost, error, agrees, strict=True):
        colour, marker = looks[variant.parameter]
        named = variant.parameter == FIDELITY
        size, layer = (6, 4) if named else (5, 3)
        face = colour if good else "white"
        ax.plot(x, y, linestyle="", marker=marker, color=colour, markerfacecolor=face, markersize=size, zorder=layer)
        if named:
            ax.annotate(
                variant.variant, (x, y), xytext=(5, 4), textcoords="offset points", fontweight="bold", zorder=5, path_effects=[HALO]
            )
    ax.set(xscale="log", yscale="log", xlabel="computing time of one run (s)")
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_minor_formatter(NullFormatter())
    ax.margins(x=0.12, y=0.08)


@styled
def figure_convergence(convergence: pd.DataFrame, table: pd.DataFrame) -> Figure:
    """A's displacement, run-out and onset against particle spacing, a curve per case; stars are values extrapolated to spacing 0.

    ``convergence`` as the file convergence.csv, ``table`` as from ``read_cost_accuracy``.  Raises ValueError for an empty one.
    """
    if convergence.empty:
        raise ValueError("convergence: no row to draw")
    quantities = list(dict.fromkeys(convergence["quantity"]))
    cases = list(dict.fromkeys(convergence["case"]))
    looks: list[dict[str, Any]] = [
        {"color": colour, "linestyle": LINE_STYLES[number % len(LINE_STYLES)], "marker": MARKERS[number % len(MARKERS)], "markersize": 4}
        for number, colour in enumerate(curve_colours(len(cases)))
    ]
    figure = Figure(figsize=(WIDTH, 3.1), layout="constrained")
    axes = figure.subplots(1, len(quantities), squeeze=False)[0]
    for ax, quantity in zip(axes, quantities, strict=True):
        for look, case in zip(looks, cases, strict=True):
            row = convergence[(convergence["quantity"] == quantity) & (convergence["case"] == case)].iloc[0]
            h, f = (np.array([float(word) for word in row[name].split()]) for name in ("spacings", "values"))
            ax.plot(h, f, **look)
            if np.isfinite(row["extrapolated"]):
                ax.plot(0.0, row["extrapolated"], linestyle="", marker="*", markersize=9, color=look["color"], clip_on=False)
        ax.set(xlabel="particle spacing (m)", xlim=(0.0, None), ylim=(0.0, 1.08 * ax.dataLim.y1))
    label_panels(axes, [ONSET.get(quantity) or metric_label(quantity) for quantity in quantities])
    handles = [Line2D([], [], label=written(case), **look) for look, case in zip(looks, cases, strict=True)]
    if np.isfinite(convergence["extrapolated"]).any():
        handles.append(Line2D([], [], linestyle="", marker="*", markersize=9, color=GREY, label="extrapolated"))
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), handlelength=3.2)
    write_note(figure, f"made on {table['machine'].iloc[0]}")
    return figure
