"""V9 and V10: slopes that just stand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from sph import trajectory
from sph.analysis.figures.style import WIDTH, curve_colours, styled
from sph.scene import Scene, make_scene
from sph.stability.safety import critical_strength_ratio, factor_of_safety
from sph.stability.search import Search, Trial
from sph.validation.level import Found, Level, Result

SEARCHES: dict[str, Callable[..., Search]] = {
    "factor_of_safety": factor_of_safety,
    "critical_strength_ratio": critical_strength_ratio,
}
REFERENCES = {"factor_of_safety": 1.385, "critical_strength_ratio": 0.46}
"""Griffiths and Lane's and Bishop and Morgenstern's factors lie at 1.37 to 1.40; 0.46 is our log-spiral limit analysis."""
TEXTS = {"factor_of_safety": "factor of safety", "critical_strength_ratio": "strength ratio at which the slope just stands"}


def search_dataset(scene: Scene, by: str, found: Search) -> xr.Dataset:
    """The trials of a search as a dataset along ``trial``, with the bracket and the scene in its attributes."""
    columns = {name: ("trial", np.array([getattr(trial, name) for trial in found.trials])) for name in Trial._fields}
    attrs: dict[str, Any] = {"by": by, "stood": found.stood, "failed": found.failed, "wall_time_s": float(columns["wall_time"][1].sum())}
    return xr.Dataset(columns, attrs=trajectory.run_attributes(scene) | attrs).astype({"stands": "int8"})


def read_search(path: Path | str) -> Result:
    """Result of a search from its file; ValueError names a file that is none."""
    data = trajectory.read(path)
    return Result(trajectory.scene_of(data, str(path)), data)


def run_search(scene: Mapping[str, Any], by: str, report: Callable[[Trial], None] | None = None) -> xr.Dataset:
    """Search the limit of a scene by one of ``SEARCHES``; its trials."""
    built = make_scene(scene)
    return search_dataset(built, by, SEARCHES[by](built, report=report))


def measure_search(level: Level) -> dict[str, Found]:
    """Middle of the bracket."""
    data = level["run"].data
    by = data.attrs["by"]
    return {by: Found(TEXTS[by], "1", 0.5 * (data.attrs["stood"] + data.attrs["failed"]), REFERENCES[by])}


@styled
def draw_search(levels: Mapping[str, Level]) -> Figure:
    """Area of displaced soil over the square of the slope's height in every trial of the search; hollow where the slope stands.

    The line is the reference.
    """
    figure = Figure(figsize=(0.65 * WIDTH, 2.9), layout="constrained")
    ax = figure.subplots()
    for marker, colour, (label, level) in zip("os^", curve_colours(len(levels)), levels.items(), strict=False):
        result = level["run"]
        by, data = result.data.attrs["by"], result.data.sortby("value")
        height = result.scene.geometry.slope_height  # type: ignore[union-attr]
        share = data["displaced_area"].values / height**2
        stands = data["stands"].values.astype(bool)
        ax.plot(data["value"], share, color=colour, linewidth=0.7)
        ax.plot(data["value"].values[~stands], share[~stands], linestyle="", marker=marker, markersize=4, color=colour, label=label)
        ax.plot(
            data["value"].values[stands], share[stands], linestyle="", marker=marker, markersize=4, color=colour, markerfacecolor="white"
        )
    ax.axvline(REFERENCES[by], color="black", linewidth=0.7)
    ax.set(xlabel=TEXTS[by], ylabel="displaced area over H²", ylim=(0.0, None))
    ax.legend(title="spacing")
    return figure
