"""The sensitivity analysis: screening, one at a time, Sobol' indices, and what the surrogate behind them is worth."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import PurePath
from typing import Any, Literal

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sph.experiments.base import metric_label, metric_words
from sph.experiments.sensitivity.factors import ENDS, Axis, with_unit
from sph.experiments.sensitivity.surrogate import KINDS, TRUSTED
from sph.figures.style import GREY, WIDTH, colour_map, curve_colours, label_panels, styled, write_note, written
from sph.study.dimensions import is_number, shown_unit

MARKERS = "osD^v<>phXP*"
"""Factors differ by these as well as by colour."""
GUIDES = {1.0: "σ = μ*", 0.1: "σ = 0.1 μ*"}
"""Slopes of the lines in the screening: above the first a factor acts unevenly or together with others, below the last evenly."""
UNTRUSTED_COLOUR = "firebrick"
MAX_LEVEL = 16
"""Most characters of a level's name."""


def _panels(table: pd.DataFrame, height: float) -> tuple[Figure, dict[str, Axes]]:
    """A figure with a panel per metric, by metric; ValueError for an empty table."""
    if table.empty:
        raise ValueError("table: no row to draw")
    metrics = list(dict.fromkeys(table["metric"]))
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, dict(zip(metrics, figure.subplots(1, len(metrics), squeeze=False)[0], strict=True))


def _unit(unit: str) -> str:
    return f" ({shown_unit(unit)})" if shown_unit(unit) else ""


def _intervals(rows: pd.DataFrame, name: str) -> np.ndarray:
    """Lengths (2, n) of error bars around a column, which may lie outside its interval."""
    return np.maximum([rows[name] - rows[f"{name}_low"], rows[f"{name}_high"] - rows[name]], 0.0)


@styled
def figure_morris(table: pd.DataFrame, factors: Sequence[Axis], chosen: Collection[str], note: str) -> Figure:
    """sigma against mu* of every factor with 95 % intervals, a panel per metric; full symbols for the ``chosen`` factors.

    ``table`` with the columns ``MORRIS``.  Raises ValueError for an empty one.
    """
    figure, axes = _panels(table, 3.5)
    looks = {
        factor.name: {"color": colour, "marker": MARKERS[number], "markerfacecolor": colour if factor.name in chosen else "white"}
        for number, (factor, colour) in enumerate(zip(factors, curve_colours(len(factors)), strict=True))
    }
    for metric, ax in axes.items():
        rows = table[table["metric"] == metric].set_index("factor")
        for name, look in looks.items():
            bars: Any = [_intervals(rows.loc[[name]], column) for column in ("mu_star", "sigma")]
            at = rows.loc[name]
            ax.errorbar(at["mu_star"], at["sigma"], bars[1], bars[0], linestyle="", markersize=5, elinewidth=0.6, **look)
        unit = rows["units"].iloc[0]
        ax.set(
            xlabel=f"mean absolute effect μ*{_unit(unit)}", ylabel=f"standard deviation σ{_unit(unit)}", xlim=(0.0, None), ylim=(0.0, None)
        )
        right, top = ax.get_xlim()[1], ax.get_ylim()[1]
        for slope, text in GUIDES.items():
            end = min(right, top / slope)
            ax.plot([0.0, end], [0.0, slope * end], color=GREY, linewidth=0.6, linestyle=":", zorder=0)
            ax.text(0.97 * end, 0.97 * slope * end, text, ha="right", va="top" if end < right else "bottom", fontsize=6.5, color=GREY)
        ax.set(xlim=(0.0, right), ylim=(0.0, top))
    label_panels(axes.values(), [_title(table, metric) for metric in axes])
    handles = [Line2D([], [], linestyle="", label=written(factor.label), **looks[factor.name]) for factor in factors]
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    write_note(figure, f"{note} · full symbols: factors of the Sobol' sample")
    return figure


@styled
def figure_tornado(table: pd.DataFrame, factors: Sequence[Axis], note: str) -> Figure:
    """The metrics at both ends of every factor, all others as in the scene; sorted by the first metric's swing, a panel per metric.

    Of a factor with levels those with the smallest and the largest metric, with their names.
    ``table`` with the columns ``TORNADO``.  A run that diverged is a cross on the base line.  Raises ValueError for an empty one.
    """
    figure, axes = _panels(table, 1.3 + 0.26 * len(factors))
    first = table[table["metric"] == table["metric"].iloc[0]]
    order = list(first.sort_values("swing", na_position="first")["factor"])
    by_name = {factor.name: factor for factor in factors}
    colours = dict(zip(ENDS, (colour_map()(0.15), colour_map()(0.7)), strict=True))
    leveled = any(factor.levels for factor in factors)
    for metric, ax in axes.items():
        rows = table[table["metric"] == metric].set_index("factor").loc[order]
        base = rows["at_base"].iloc[0]
        for shift, (end, colour) in zip((0.17, -0.17), colours.items(), strict=True):
            reach = rows[f"at_{end}"].to_numpy() - base
            ax.barh(np.arange(len(order)) + shift, np.nan_to_num(reach), left=base, height=0.34, color=colour)
            for place, name in enumerate(order):
                if by_name[name].levels and not np.isnan(reach[place]):
                    side = -1.0 if reach[place] < 0.0 else 1.0
                    look: Any = {"ha": "left" if side > 0.0 else "right", "va": "center", "fontsize": 5.5, "textcoords": "offset points"}
                    ax.annotate(_level(by_name[name], rows[end][name]), (base + reach[place], place + shift), (2.0 * side, 0.0), **look)
            lost = np.flatnonzero(np.isnan(reach))
            ax.plot(np.full(lost.size, base), lost + shift, linestyle="", marker="x", color=UNTRUSTED_COLOUR)
        ax.axvline(base, color="black", linewidth=0.8)
        ax.set(xlabel=metric_label(metric), yticks=np.arange(len(order)), yticklabels=[])
        ax.tick_params(axis="y", length=0)
        ax.spines["left"].set_visible(False)
        ax.margins(x=0.4 if leveled else 0.06, y=0.02)  # room for names
        if not (rows[["at_base", *(f"at_{end}" for end in ENDS)]] < 0.0).any(axis=None):
            low, high = ax.get_xlim()
            ax.set_xticks([tick for tick in ax.get_xticks() if 0.0 <= tick <= high])
            ax.set_xlim(low, high)
    leftmost = next(iter(axes.values()))
    leftmost.set_yticklabels(
        [f"{written(factor.label)}\n{_range(factor)}" for factor in (by_name[name] for name in order)],
        fontsize=7,
    )
    label_panels(axes.values(), [metric_words(metric) for metric in axes])
    words = {
        end: f"{end} end of the range" + f", or level with the {most}" * leveled for end, most in zip(ENDS, ("least", "most"), strict=True)
    }
    handles = [Line2D([], [], color=colour, linewidth=6, label=words[end]) for end, colour in colours.items()]
    handles.append(Line2D([], [], color="black", linewidth=0.8, label="scene as it is"))
    if table["diverged"].any():
        handles.append(Line2D([], [], linestyle="", marker="x", color=UNTRUSTED_COLOUR, label="diverged"))
    figure.legend(handles=handles, loc="outside upper center", ncols=2 if leveled else 4)
    write_note(figure, note)
    return figure


def _range(factor: Axis) -> str:
    """The ends of a factor's range, or the number of its levels."""
    return f"{len(factor.levels)} levels" if factor.levels else factor.span(factor.low, factor.high)


def _level(factor: Axis, number: float) -> str:
    """A level as it is read: of a file its name alone."""
    parts = factor.levels[int(number) - 1].split(", ")
    name = ", ".join(part if is_number(part) else PurePath(part).stem for part in parts)
    return name if len(name) <= MAX_LEVEL else f"{name[: MAX_LEVEL - 1]}…"


@styled
def figure_sobol(table: pd.DataFrame, factors: Sequence[Axis], note: str) -> Figure:
    """First-order and total indices with 95 % intervals and the Q2 of the surrogate, a panel per metric.

    ``table`` with the columns ``SOBOL``; what is not to be trusted is pale and says so.  Raises ValueError for an empty one.
    """
    figure, axes = _panels(table, 3.4)
    labels = {factor.name: written(factor.label) for factor in factors}
    looks = dict(zip(KINDS, (colour_map()(0.15), colour_map()(0.7)), strict=True))
    for number, (metric, ax) in enumerate(axes.items()):
        rows = table[table["metric"] == metric]
        trusted = rows["verdict"].iloc[0] == TRUSTED
        places = np.arange(len(rows))[::-1]
        for shift, (name, colour) in zip((0.2, -0.2), looks.items(), strict=True):
            ax.barh(places + shift, rows[name], 0.38, color=colour, alpha=0.85 if trusted else 0.25)
            ax.errorbar(rows[name], places + shift, xerr=_intervals(rows, name), linestyle="", color="black", elinewidth=0.8, capsize=2)
        ax.set(xlim=(min(0.0, ax.get_xlim()[0]), 1.0), xlabel="Sobol' index", yticks=places)
        ax.set_yticklabels([labels[name] for name in rows["factor"]] if number == 0 else [])
        ax.tick_params(axis="y", length=0)
        ax.axvline(0.0, color="black", linewidth=0.6)
        ax.set_ylim(-0.6, 1.2 * len(rows))  # room for the text
        _state(ax, f"Q² = {rows['q2'].iloc[0]:.2f}", rows["verdict"].iloc[0].replace(": ", ":\n"), "top")
    label_panels(axes.values(), [_title(table, metric) for metric in axes])
    handles = [Line2D([], [], color=colour, linewidth=6, label=text) for text, colour in zip(
        ("first order", "total"), looks.values(), strict=True)]  # fmt: skip
    figure.legend(handles=handles, loc="outside upper center", ncols=2)
    write_note(figure, note)
    return figure


def _state(ax: Axes, text: str, verdict: str, corner: Literal["top", "bottom"]) -> None:
    """A text at the right, with the verdict where that is not trusted."""
    trusted, y = verdict == TRUSTED, {"top": 0.99, "bottom": 0.02}[corner]
    colour = "black" if trusted else UNTRUSTED_COLOUR
    ax.text(0.98, y, text if trusted else f"{text}\n{verdict}", transform=ax.transAxes, ha="right", va=corner, fontsize=7.5, color=colour)


def _title(table: pd.DataFrame, metric: str) -> str:
    logarithmic = table[table["metric"] == metric]["quantity"].iloc[0] != metric
    return f"{metric_words(metric)}{', log' if logarithmic else ''}"


@styled
def figure_cross_validation(table: pd.DataFrame, indices: pd.DataFrame, note: str) -> Figure:
    """Prediction of the surrogate for every run, fitted without that run, with two of its standard deviations, against the computed
    value; a panel per metric.

    ``table`` with the columns ``CROSS_VALIDATION``, ``indices`` with those of ``SOBOL``.  Raises ValueError for an empty one.
    """
    figure, axes = _panels(table, 2.9)
    titles = []
    for metric, ax in axes.items():
        rows, facts = table[table["metric"] == metric], indices[indices["metric"] == metric].iloc[0]
        ax.errorbar(rows["computed"], rows["predicted"], 2 * rows["predicted_sd"], linestyle="", marker="o", markersize=2.5,
                    color=colour_map()(0.15), ecolor="0.75", elinewidth=0.6)  # fmt: skip
        ends = [float(rows["computed"].min()), float(rows["computed"].max())]
        ax.plot(ends, ends, color="black", linewidth=0.8)
        logarithmic = facts["quantity"] != metric
        scale = f", {facts['quantity'].replace(metric, 'u')}" if logarithmic else _unit(facts["units"])
        titles.append(f"{metric_words(metric)}{', u' * logarithmic}")
        ax.set(xlabel=f"computed{scale}", ylabel=f"predicted{scale}")
        text = f"Q² = {facts['q2']:.2f}, RMSE {with_unit(facts['rmse'], facts['units'])}"
        _state(ax, text, facts["verdict"], "bottom")
    label_panels(axes.values(), titles)
    write_note(figure, f"{note} · bars: two standard deviations")
    return figure
