"""V9, V10, V17 and V18: slopes that just stand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from matplotlib.figure import Figure

from sph.figures.style import WIDTH, curve_colours, styled
from sph.scene.geometry import Slope
from sph.scene.gravity import GRAVITY
from sph.stability.extrapolation import extrapolate
from sph.stability.limit_analysis import limit_factor, limit_strength_ratio
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


LIMITS = {"onset_factor": limit_factor, "onset_strength_ratio": limit_strength_ratio}
"""Limit analysis of what a search finds."""


def measure_limits(level: Level) -> dict[str, Found]:
    """Limit found for every slope, beside the upper bound of limit analysis."""
    return {name: _beside_limit(result) for name, result in level.items()}


def _beside_limit(result: Result) -> Found:
    slope, soil, data = result.scene.geometry, result.scene.soil, result.data
    assert isinstance(slope, Slope)
    by = data.attrs["by"]
    weight, depth = soil.density * GRAVITY, slope.base_depth
    limit = LIMITS[by](slope.slope_angle, slope.slope_height, weight, soil.cohesion_si, soil.friction_angle, depth)
    symbol = "F" if by == "onset_factor" else "S_R"
    text = f"{symbol}, {slope.slope_angle:g}°, φ = {soil.friction_angle:g}°"
    return Found(text, "1", float(data.attrs["value"]), limit)


@styled
def draw_limits(levels: Mapping[str, Level]) -> Figure:
    """Error of every slope's limit against the spacing over its height, and the line through the two finest spacings to 0."""
    figure = Figure(figsize=(0.65 * WIDTH, 2.9), layout="constrained")
    ax = figure.subplots()
    found = [measure_limits(level) for level in levels.values()]
    for colour, name in zip(curve_colours(len(found[-1])), found[-1], strict=True):
        sizes = [level[name].scene.numerics.spacing / level[name].scene.geometry.slope_height for level in levels.values()]  # type: ignore[union-attr]
        errors = [100.0 * each[name].error for each in found]
        zero = extrapolate(errors[-2], errors[-1], sizes[-2] / sizes[-1])
        ax.plot([*sizes, 0.0], [*errors, zero], color=colour, marker="o", markersize=3, linewidth=0.7, label=found[-1][name].text)
    ax.axhline(0.0, color="black", linewidth=0.7)
    ax.set(xlabel="spacing over H", ylabel="error (%)", xlim=(0.0, None))
    ax.legend(fontsize="xx-small", ncols=2)
    return figure
