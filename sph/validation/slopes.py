"""V9 and V10: slopes that just stand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from matplotlib.figure import Figure

from sph.figures.style import WIDTH, curve_colours, styled
from sph.storage import trajectory
from sph.validation.level import Found, Level, Result

REFERENCES = {"factor_of_safety": 1.385, "critical_strength_ratio": 0.46}
"""Griffiths and Lane's and Bishop and Morgenstern's factors lie at 1.37 to 1.40; 0.46 is our log-spiral limit analysis."""
TEXTS = {"factor_of_safety": "factor of safety", "critical_strength_ratio": "strength ratio at which the slope just stands"}


def read_search(path: Path | str) -> Result:
    """Result of a search from its file; ValueError names a file that is none."""
    data = trajectory.read(path)
    return Result(trajectory.scene_of(data, str(path)), data)


def measure_search(level: Level) -> dict[str, Found]:
    """Middle of the bracket."""
    data = level["run"].data
    by = data.attrs["by"]
    return {by: Found(TEXTS[by], "1", float(data.attrs["value"]), REFERENCES[by])}


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
