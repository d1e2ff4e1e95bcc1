"""How far the slope moves under many motions: share of the runs that exceed a run-out or a displacement, and how far along the section."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.exceedance import LENGTHS
from sph.figures.arrangement import draw_ground, draw_water
from sph.figures.profile import survey_axes
from sph.figures.style import LINE_STYLES, WIDTH, curve_colours, label_panels, plain, styled, write_note
from sph.scene.geometry import SLOPES
from sph.scene.schema import Scene

LABELS = {"runout": "run-out (m)", "displacement_magnitude": "displacement of the probe (m)"}
SHARE = 0.16
"""Height of the shares above a section, over its width."""
GAP = 0.03
"""Between both, likewise."""
PANEL, OUTSIDE = 2.4, 0.75
"""Inches of a curve's panel, and of the labels of a section."""


@styled
def figure_reach(table: pd.DataFrame, searched: Searched, scenes: Mapping[str, Scene], note: str = "") -> Figure:
    """Share of the motions that exceed a run-out and a displacement, a line per intensity, for each case; bands are diverged runs.

    ``table`` as from ``exceedance``.  Below, for a case with a scene, the share of the motions whose debris reaches a place, above
    the section.  Raises ValueError for an empty table.
    """
    if table.empty:
        raise ValueError("exceedance: no row to draw")
    cases = list(dict.fromkeys(table["case"]))
    sections = {
        case: scenes[case]
        for case in cases
        if case in scenes and isinstance(scenes[case].geometry, SLOPES) and "runout" in set(table.loc[table["case"] == case, "metric"])
    }
    heights = [PANEL + (_section_height(sections[case]) if case in sections else 0.0) for case in cases]
    figure = Figure(figsize=(WIDTH, sum(heights) + 0.3), layout="constrained")
    parts = figure.subfigures(len(cases), 1, squeeze=False, height_ratios=heights)[:, 0]
    panels, titles = list[Axes](), list[str]()
    for part, case in zip(parts, cases, strict=True):
        rows = table[table["case"] == case]
        of_case = f": {plain(case)}" if len(cases) > 1 else ""
        metrics = [name for name in LENGTHS if (rows["metric"] == name).any()]
        grid = part.add_gridspec(
            1 + (case in sections), 1, height_ratios=[PANEL, _section_height(sections[case])] if case in sections else None
        )
        axes = grid[0].subgridspec(1, len(metrics)).subplots(sharey=True, squeeze=False)[0]
        levels = sorted(set(rows["intensity"]))
        looks = {level: _look(number, len(levels)) for number, level in enumerate(levels)}
        for ax, name in zip(axes, metrics, strict=True):
            end = 1.03 * float(rows.loc[rows["metric"] == name, "exceeded"].max()) or 1.0
            for level in levels:
                _draw_share(ax, rows[(rows["metric"] == name) & (rows["intensity"] == level)], looks[level], end)
            ax.set(xlim=(0.0, end), ylim=(0.0, 1.02), xlabel=LABELS[name])
        axes[0].set_ylabel("share of the motions")
        panels += list(axes)
        titles += [f"{LABELS[name].split(' (')[0]} exceeded{of_case}" for name in metrics]
        if case in sections:
            ax = part.add_subplot(grid[1])
            _draw_section(ax, sections[case], rows[rows["metric"] == "runout"], looks)
            panels.append(ax)
            titles.append(f"share of the motions whose debris reaches a place{of_case}")
        handles = [axes[0].plot([], [], label=_words(rows, level, searched), **looks[level])[0] for level in levels]
        part.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 2), handlelength=3.0)
    label_panels(panels, titles)
    write_note(figure, note)
    return figure


def _look(number: int, count: int) -> dict[str, Any]:
    return {"color": curve_colours(count)[number], "linestyle": LINE_STYLES[number % len(LINE_STYLES)]}


def _words(rows: pd.DataFrame, level: float, searched: Searched) -> str:
    """An intensity, its runs and those that say less than the others."""
    row = rows[rows["intensity"] == level].iloc[0]
    counted = {"diverged": "diverged (band)", "braked": "braked (band)", "still_moving": "still moving, may go farther"}
    others = "".join(f", {row[name]} {words}" for name, words in counted.items() if row[name])
    return plain(f"{level:g} {searched.intensity.shown_unit}".rstrip() + f": {row['motions']} motions{others}")


def _draw_share(ax: Axes, curve: pd.DataFrame, look: dict[str, Any], end: float, toe: float = 0.0, towards: float = 1.0) -> None:
    """The steps of a curve up to a length ``end``, at ``toe`` + ``towards`` times the length, with the band of the diverged runs."""
    at = toe + towards * np.append(curve["exceeded"], end)
    lower, upper = (np.append(curve[name], curve[name].iloc[-1]) for name in ("share_lower", "share_upper"))
    ax.step(at, lower, where="post", **look)
    if (upper > lower).any():
        ax.fill_between(at, lower, upper, step="post", color=look["color"], alpha=0.15, linewidth=0)


def _section_height(scene: Scene) -> float:
    """Inches of a section with the shares above it."""
    return WIDTH * (_top(scene) / scene.geometry.width) + OUTSIDE


def _top(scene: Scene) -> float:
    return scene.geometry.height + (GAP + SHARE) * scene.geometry.width


def _draw_section(ax: Axes, scene: Scene, rows: pd.DataFrame, looks: Mapping[float, dict[str, Any]]) -> None:
    """The ground to scale with its water, and above it, place over place, the share of the motions whose debris comes there."""
    geometry, top = scene.geometry, _top(scene)
    draw_ground(ax, scene)
    draw_water(ax, scene, named=True)
    survey_axes(ax, scene, (0.0, geometry.width, 0.0, top))
    ax.set_ylabel(ax.get_ylabel(), y=0.5 * geometry.height / top)
    ax.spines["left"].set_bounds(0.0, geometry.height)
    ax.set_yticks([tick for tick in ax.get_yticks() if 0.0 <= tick <= geometry.height])
    above = ax.inset_axes((0.0, 1.0 - SHARE * geometry.width / top, 1.0, SHARE * geometry.width / top))
    toe = geometry.toe[0]
    for level, look in looks.items():
        _draw_share(above, rows[rows["intensity"] == level], look, toe, toe, -1.0)
    above.set(xlim=ax.get_xlim(), ylim=(0.0, 1.02), ylabel="share", xticks=[])
    for place in (ax, above):
        place.axvline(toe, color="0.6", linewidth=0.6, zorder=0)
