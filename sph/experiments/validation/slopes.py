"""V9, V10, V16 to V19, V21 and V22: slopes that just stand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from sph.experiments.validation.level import Found, Level, Result
from sph.figures.style import WIDTH, curve_colours, styled
from sph.scene.geometry import Slope
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene
from sph.stability.extrapolation import extrapolate
from sph.stability.limit_analysis import DRY, Wet, infinite_slope_factor, limit_factor, limit_strength_ratio
from sph.stability.standing import slope_height
from sph.storage import trajectory

PUBLISHED_FACTORS = {"run": 1.385, "acads_1a": 1.00}
"""Factors of safety of V9: Griffiths and Lane's and Bishop and Morgenstern's lie at 1.37 to 1.40; that of ACADS 1(a)."""
SEISMIC_BOUNDS = {"dry": (0.423, 0.454), "wet": (0.126, 0.145)}
"""Rigorous bounds of the critical seismic coefficient of V22 (Loukidis, Bandini and Salgado 2003), by the first word of its runs."""
CHART_FACTOR = 1.35
"""Factor of safety of V16's 4:1 slope by the charts of Bishop and Morgenstern (1960), m = 1.97 and n = 1.78 as GEO-SLOPE reads them."""
LIMITS = {"factor_of_safety": limit_factor, "critical_strength_ratio": limit_strength_ratio}
"""Limit analysis of what a search finds."""


def read_search(path: Path | str) -> Result:
    """Result of a search from its file; ValueError names a file that is not one."""
    data = trajectory.read(path)
    return Result(trajectory.scene_of(data, str(path)), data)


def measure_search(level: Level) -> dict[str, Found]:
    """Middle of the bracket of each slope."""

    def found(run: str, text: str) -> Found:
        return Found(text, "1", float(level[run].data.attrs["value"]), PUBLISHED_FACTORS[run])

    return {"factor_of_safety": found("run", "factor of safety"), "acads_1a": found("acads_1a", "factor of safety, ACADS 1(a)")}


def measure_seismic(level: Level) -> dict[str, Found]:
    """Critical seismic coefficient of the slopes with associated flow, beside the middle of its bounds."""
    return {name: _seismic(name, result) for name, result in level.items() if not name.endswith("no_dilation")}


def _seismic(name: str, result: Result) -> Found:
    water, bounds = name.split("_")[0], SEISMIC_BOUNDS[name.split("_")[0]]
    text = f"k, {water}, E = {result.scene.soil.youngs_modulus / 1e3:g} MPa, ψ = {result.scene.soil.dilation_angle:g}°"
    return Found(text, "1", float(result.data.attrs["value"]) / GRAVITY, sum(bounds) / 2.0)


@styled
def draw_seismic(levels: Mapping[str, Level]) -> Figure:
    """Critical seismic coefficients against the spacing over H, extrapolated to 0, between their bounds; hollow without dilation."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    runs = [{name: _seismic(name, result) for name, result in level.items()} for level in levels.values()]
    for ax, (water, (low, high)) in zip(figure.subplots(1, 2), SEISMIC_BOUNDS.items(), strict=True):
        ax.axhspan(low, high, color="0.85", linewidth=0.0)
        shown = [name for name in runs[-1] if name.startswith(water)]
        for marker, colour, name in zip("os^", curve_colours(len(shown)), shown, strict=True):
            sizes = [level[name].scene.numerics.spacing / slope_height(level[name].scene) for level in levels.values()]
            values = [each[name].computed for each in runs]
            zero = extrapolate(values[-2], values[-1], sizes[-2] / sizes[-1]) if len(values) > 1 else values[-1]
            face = "white" if name.endswith("no_dilation") else colour
            label = runs[-1][name].text.removeprefix(f"k, {water}, ")
            ax.plot(
                [*sizes, 0.0], [*values, zero], color=colour, marker=marker, markerfacecolor=face, markersize=4, linewidth=0.7, label=label
            )
        ax.set(title=water, xlabel="spacing over H", ylabel="critical seismic coefficient", xlim=(0.0, None))
        ax.legend(fontsize="xx-small")
    return figure


@styled
def draw_search(levels: Mapping[str, Level]) -> Figure:
    """Area of displaced soil over the square of the slope's height in every trial of the searches; hollow where the slope stands.

    The lines are the references.
    """
    figure = Figure(figsize=(0.65 * WIDTH, 2.9), layout="constrained")
    ax = figure.subplots()
    for marker, colour, (label, level) in zip("os^", curve_colours(len(levels)), levels.items(), strict=False):
        for run, result in level.items():
            data = result.data.sortby("value")
            share = data["displaced_area"].values / slope_height(result.scene) ** 2
            stands = data["stands"].values.astype(bool)
            ax.plot(data["value"], share, color=colour, linewidth=0.7)
            for verdict, face, told in ((~stands, colour, label if run == "run" else None), (stands, "white", None)):
                values = data["value"].values[verdict]
                ax.plot(values, share[verdict], linestyle="", marker=marker, markersize=4, color=colour, markerfacecolor=face, label=told)
    for factor in PUBLISHED_FACTORS.values():
        ax.axvline(factor, color="black", linewidth=0.7)
    ax.set(xlabel="factor of safety", ylabel="displaced area over H²", ylim=(0.0, None))
    ax.legend(title="spacing")
    return figure


def measure_limits(level: Level) -> dict[str, Found]:
    """Limit found for every slope, beside the upper bound of limit analysis, or the closed form of one without end."""
    return {name: _beside_limit(result) for name, result in level.items()}


def _beside_limit(result: Result) -> Found:
    slope, soil, data = result.scene.geometry, result.scene.soil, result.data
    by, weight = data.attrs["by"], soil.density * GRAVITY
    if not isinstance(slope, Slope):
        tilt, water = result.scene.gravity.inclination, result.scene.water
        ratio = 0.0 if water is None else water.r_u or 0.0
        limit = infinite_slope_factor(tilt, slope.height, weight, soil.cohesion_si, soil.friction_angle, soil.dilation_angle, ratio)
        text = f"F, infinite slope of {tilt:g}°, φ = {soil.friction_angle:g}°, ψ = {soil.dilation_angle:g}°"
        if water is not None:
            text += f", r_u = {ratio:g} {water.pressure}"
        if result.scene.walls.base != "no_slip":
            text += f", {result.scene.walls.base} base"
        return Found(text, "1", float(data.attrs["value"]), limit)
    depth, wet = slope.base_depth, _wet(result.scene)
    limit = LIMITS[by](slope.slope_angle, slope.slope_height, weight, soil.cohesion_si, soil.friction_angle, depth, wet)
    symbol = "F" if by == "factor_of_safety" else "S_R"
    water_text = "" if wet == DRY else f", r_u = {wet.r_u:g}" if wet.r_u else f", water {wet.level:g} H above the toe"
    text = f"{symbol}, {slope.slope_angle:g}°, φ = {soil.friction_angle:g}°{water_text}"
    return Found(text, "1", float(data.attrs["value"]), limit)


def measure_drawdown(level: Level) -> dict[str, Found]:
    """Limits of a slope at several levels of its water, the level of the lowest, and that of a slope with r_u beside the charts."""
    found = measure_limits(level)
    chart = found["chart"]
    drawn = {name: limit for name, limit in found.items() if name != "chart"}
    lowered = np.array([_drawdown(level[name].scene) for name in drawn])
    computed, reference = np.array([(limit.computed, limit.reference) for limit in drawn.values()]).T
    return {
        **drawn,
        "lowest": Found("L/H of the lowest F", "1", lowest_between(lowered, computed), lowest_between(lowered, reference)),
        "chart": Found(f"{chart.text}, charts", "1", chart.computed, CHART_FACTOR),
    }


def lowest_between(x: np.ndarray, y: np.ndarray) -> float:
    """Where the parabola through the lowest of some points (n,) and its two neighbours is lowest; an end that is lowest itself."""
    order = np.argsort(x)
    x, y = x[order], y[order]
    lowest = int(np.argmin(y))
    if lowest in (0, len(x) - 1):
        return float(x[lowest])
    near = slice(lowest - 1, lowest + 2)
    square, slope, _ = np.polyfit(x[near], y[near], 2)
    return float(-slope / (2.0 * square))


def _drawdown(scene: Scene) -> float:
    """Depth L of the water's level below the crest over H."""
    return 1.0 - _wet(scene).level


@styled
def draw_drawdown(levels: Mapping[str, Level]) -> Figure:
    """Factor of safety against the depth of the water's level below the crest, beside limit analysis."""
    figure = Figure(figsize=(0.65 * WIDTH, 2.9), layout="constrained")
    ax = figure.subplots()
    for marker, colour, (label, level) in zip("os^", curve_colours(len(levels)), levels.items(), strict=False):
        found = {name: limit for name, limit in measure_limits(level).items() if name != "chart"}
        lowered = [_drawdown(level[name].scene) for name in found]
        ax.plot(
            lowered, [limit.computed for limit in found.values()], color=colour, marker=marker, markersize=4, linewidth=0.7, label=label
        )
    ax.plot(lowered, [limit.reference for limit in found.values()], color="black", linewidth=0.9, label="limit analysis")
    ax.set(xlabel="depth of the water level below the crest, L/H", ylabel="factor of safety")
    ax.legend(title="spacing")
    return figure


def _wet(scene: Scene) -> Wet:
    """Water of a slope, with one level in it and before it or with one r_u, for limit analysis."""
    water, slope = scene.water, scene.geometry
    if water is None:
        return DRY
    if water.r_u is not None:
        return Wet(r_u=water.r_u)
    assert water.level is not None
    weight = scene.soil.density * scene.gravity.acceleration
    return Wet(1e3 * water.unit_weight / weight, (water.level - slope.toe[1]) / (slope.crest[1] - slope.toe[1]))


@styled
def draw_limits(levels: Mapping[str, Level]) -> Figure:
    """Error of every slope's limit against the spacing over its height, and the line through the two finest spacings to 0."""
    figure = Figure(figsize=(0.65 * WIDTH, 2.9), layout="constrained")
    ax = figure.subplots()
    found = [measure_limits(level) for level in levels.values()]
    for colour, name in zip(curve_colours(len(found[-1])), found[-1], strict=True):
        sizes = [level[name].scene.numerics.spacing / slope_height(level[name].scene) for level in levels.values()]
        errors = [100.0 * each[name].error for each in found]
        zero = extrapolate(errors[-2], errors[-1], sizes[-2] / sizes[-1])
        ax.plot([*sizes, 0.0], [*errors, zero], color=colour, marker="o", markersize=3, linewidth=0.7, label=found[-1][name].text)
    ax.axhline(0.0, color="black", linewidth=0.7)
    ax.set(xlabel="spacing over H", ylabel="error (%)", xlim=(0.0, None))
    ax.legend(fontsize="xx-small", ncols=2)
    return figure
