"""V23: a column of aluminium rods, point by point."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from cases.case import Case, Found, Kind, Level, Quantity, Result, at_spacings
from cases.flows import SHARE, column, reach_of_share, spread
from sph.figures.style import LINE_STYLES, WIDTH, curve_colours, label_panels, styled

RUNS = ("rods", "rods2")
"""The runs, with the two friction angles that were measured for such rods."""
SURFACE = 1e-3 * np.array(
    [
        [0.1, 99.2], [19.6, 99.3], [39.8, 95.9], [60.0, 89.0], [80.3, 84.4], [100.1, 77.6], [120.3, 72.2], [140.1, 66.5], [160.3, 61.6],
        [180.2, 53.9], [200.0, 47.4], [220.2, 42.5], [240.8, 34.8], [262.2, 30.7], [282.0, 26.5], [302.2, 21.5], [322.1, 18.9],
        [342.3, 13.6], [362.2, 10.9], [382.4, 7.9], [402.2, 3.7], [422.1, 2.2], [442.3, 1.5],
    ]
)  # fmt: skip
"""Distance from the wall and height (23, 2) of the deposit's surface, m (Bui et al. 2008, as digitised in data of two other programs)."""
LINE = 1e-3 * np.array(
    [[21.2, 98.9], [39.8, 90.1], [60.0, 80.2], [79.7, 65.2], [99.9, 54.5], [119.6, 36.8], [139.4, 25.7], [159.6, 10.4], [179.4, 0.5]]
)  # fmt: skip
"""Distance from the wall and height (9, 2) of rods that moved by ``MOVED``, m (likewise)."""
MOVED = 1e-3
"""Displacement of the line between the rods that stay and those that move, m."""
HIGH = 0.01
"""Heights are compared one by one where the measured deposit is higher than this, m."""
GRAIN = 0.002
"""The deposit ends where it is as high as one grain, m."""


def surface(result: Result, places: np.ndarray) -> np.ndarray:
    """Height (n,) of the deposit at distances from the wall (n,), m: that of its highest particle within a spacing; 0 beyond it."""
    distance, height = spread(result)
    spacing = result.scene.numerics.spacing
    near = np.abs(distance[None, :] - places[:, None]) < spacing
    top: np.ndarray = np.where(near, height[None, :] + 0.5 * spacing, 0.0).max(axis=1)
    return top


def reach(places: np.ndarray, heights: np.ndarray) -> float:
    """Distance at which a surface (n,) falls below ``GRAIN`` for good, m."""
    last = int(np.flatnonzero(heights >= GRAIN)[-1])
    if last == places.size - 1:
        return float(places[-1])
    return float(np.interp(-GRAIN, -heights[last : last + 2], places[last : last + 2]))


def failure_line(result: Result) -> np.ndarray:
    """Distance from the wall and height (rows, 2) at the start of what moved by ``MOVED``, m: in each row of particles, between the last
    one from the wall that moved less and the first that moved more."""
    x0, y0 = result.start("x0"), result.start("y0")
    moved = np.hypot(result.frame("x") - x0, result.frame("y") - y0)
    found = []
    for row in np.unique(y0.round(9)):
        own = np.flatnonzero(y0.round(9) == row)
        own = own[np.argsort(-x0[own])]  # from the wall, which is on the right
        distance, slid = result.scene.geometry.width - x0[own], moved[own]
        if (slid > MOVED).any():
            first = int(np.argmax(slid > MOVED))
            ends = slice(max(first - 1, 0), first + 1)
            found.append([float(np.interp(MOVED, slid[ends], distance[ends])), row])
    return np.array(found)


def foot_and_angle(line: np.ndarray) -> tuple[float, float]:
    """Distance from the wall (m) at which a straight line through points (n, 2) meets the base, and its dip, degrees."""
    run, foot = np.polyfit(line[:, 1], line[:, 0], 1)
    return float(foot), float(np.degrees(np.arctan2(1.0, -run)))


def measure_rods(level: Level) -> dict[str, Found]:
    """Surface, reach and failure line beside those of the test."""
    measured, (foot, angle) = SURFACE[:, 1], foot_and_angle(LINE)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (measured[1:] + measured[:-1]) * np.diff(SURFACE[:, 0]))])
    mass = float(np.interp(SHARE, area / area[-1], SURFACE[:, 0]))
    found: dict[str, Found] = {}
    for name in RUNS:
        result = level[name]
        case, off = f"φ = {result.scene.soil.friction_angle:g}°", surface(result, SURFACE[:, 0]) - measured
        high = measured > HIGH
        places = np.arange(0.0, result.scene.geometry.width, result.scene.numerics.spacing)
        at, dip = foot_and_angle(failure_line(result))
        found |= {
            f"misfit_{name}": Found(f"misfit of the surface P_d, {case}", "1", float(np.sqrt((off**2).sum() / (measured**2).sum())), 0.0),
            f"height_{name}": Found(f"largest error of a height, {case}", "m", float(np.abs(off[high]).max()), 0.0),
            f"reach_{name}": Found(f"reach, 2 mm high, {case}", "m", reach(places, surface(result, places)), reach(*SURFACE.T)),
            f"mass99_{name}": Found(f"distance that holds 99 % of the mass, {case}", "m", reach_of_share(result), mass),
            f"foot_{name}": Found(f"foot of the line of 1 mm displacement, {case}", "m", at, foot),
            f"angle_{name}": Found(f"dip of that line, {case}", "degree", dip, angle),
        }
    return found


@styled
def draw_rods(levels: Mapping[str, Level]) -> Figure:
    """Deposit of a column of aluminium rods: measured surface (circles) and line of 1 mm displacement (crosses), and those computed;
    dashed the column at the start."""
    figure = Figure(figsize=(WIDTH, 3.9), layout="constrained")
    axes = figure.subplots(len(RUNS), 1, sharex=True)
    titles = []
    for ax, name in zip(axes, RUNS, strict=True):
        for look, colour, (label, level) in zip(LINE_STYLES, curve_colours(len(levels)), levels.items(), strict=False):
            places = np.arange(0.0, 0.6, 0.5 * level[name].scene.numerics.spacing)
            ax.plot(1e3 * places, 1e3 * surface(level[name], places), color=colour, linestyle=look, linewidth=1.0, label=label)
            ax.plot(*(1e3 * failure_line(level[name])).T, color=colour, linestyle=look, linewidth=1.0)
        ax.plot(*(1e3 * SURFACE).T, "o", color="black", markersize=3, markerfacecolor="none", label="measured surface")
        ax.plot(*(1e3 * LINE).T, "x", color="black", markersize=4, label="measured, moved by 1 mm")
        length, height = column(level[name].scene)
        ax.plot(np.array([0.0, 1e3, 1e3]) * length, np.array([1e3, 1e3, 0.0]) * height, color="black", linestyle="--", linewidth=0.6)
        ax.set(aspect="equal", ylabel="height (mm)", xlim=(0.0, 560.0), ylim=(0.0, 112.0))
        titles.append(f"φ = {level[name].scene.soil.friction_angle:g}°")
    axes[-1].set_xlabel("distance from the wall (mm)")
    label_panels(axes, titles)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(levels) + 2)
    return figure


ASKED = {
    "misfit": Quantity(Kind.PROFILE, 0.05, 0.10, "one test; another program has about 0.01 for a similar one"),
    "height": Quantity(Kind.HEIGHT, 0.005, 0.010, "three to five rods, where the deposit is higher than 10 mm"),
    "reach": Quantity(Kind.RUNOUT, 0.10, 0.20, "height of one or two rods; the front grows with finer particles"),
    "mass99": Quantity(Kind.RUNOUT, 0.15, 0.25, "1 % of the mass is the thin end of the deposit"),
    "foot": Quantity(Kind.LENGTH, 0.056, 0.112, "10 mm"),
    "angle": Quantity(Kind.ANGLE, 0.091, 0.182, "3 degrees"),
}
V23 = Case(
    title="Collapse of a column of rods, point by point",
    scene="config/scenes/validation/v23_rods.yaml",
    source="test with aluminium rods, Bui, Fukagawa, Sako and Ohno (2008), doi 10.1002/nag.688, as digitised in data of two other programs",
    reference="published",
    ours="stiffness between published ones, walls, and the measures of misfit",
    measure=measure_rods,
    draw=draw_rods,
    runs={"rods": {}, "rods2": {"soil": {"friction_angle": 21.9}}},
    levels=at_spacings({"10 mm": 0.01, "5 mm": 0.005, "2.5 mm": 0.0025}),
    # One test, digitised once: the area under its surface is 1.5 % above the column's.  The rods are 1 and 1.5 mm thick.
    quantities={f"{name}_{run}": asked for name, asked in ASKED.items() for run in RUNS},
)
