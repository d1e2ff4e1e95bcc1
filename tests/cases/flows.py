"""V6 to V8 and V25: flows of Bingham fluid and of grains."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from cases.case import Case, Found, Kind, Level, Quantity, Result, at_spacings
from cases.columns import row_means
from sph.figures.profile import draw_circles
from sph.figures.style import LINE_STYLES, WIDTH, curve_colours, label_panels, styled
from sph.measures.linked import largest_mass
from sph.measures.metrics import MetricSettings
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene

# ---------------------------------------------------------------- V6: plane Poiseuille flow

PLUG = 0.99
"""The plug is where the fluid is faster than this share of its largest speed."""


def poiseuille(scene: Scene, y: np.ndarray) -> np.ndarray:
    """Speed (m/s) of the Bingham fluid at heights (n,) between the plates, driven by gravity along them."""
    half, soil = 0.5 * scene.geometry.height, scene.soil
    force = soil.density * scene.gravity.acceleration
    sheared = half - soil.cohesion_si / force
    wall = np.minimum(np.minimum(y, 2.0 * half - y), sheared)
    return (force * (half * wall - 0.5 * wall**2) - soil.cohesion_si * wall) / soil.viscosity


def incline(scene: Scene, y: np.ndarray) -> np.ndarray:
    """Speed (m/s) at heights (n,) of a layer of Bingham fluid down an incline: the lower half of a channel twice as high."""
    soil, (_, thickness) = scene.soil, column(scene)
    force = soil.density * scene.gravity.acceleration * math.sin(math.radians(scene.gravity.inclination))
    sheared = np.minimum(y, thickness - soil.cohesion_si / force)
    return (force * (thickness * sheared - 0.5 * sheared**2) - soil.cohesion_si * sheared) / soil.viscosity


def _plug_half_width(y: np.ndarray, speed: np.ndarray) -> float:
    """Half the height over which a profile (n,) is faster than ``PLUG`` of its top, between rows by interpolation."""
    limit = PLUG * speed.max()
    fast = np.flatnonzero(speed >= limit)
    low, high = fast[0], fast[-1]
    lower = np.interp(limit, speed[low - 1 : low + 1], y[low - 1 : low + 1])
    upper = np.interp(-limit, -speed[high : high + 2], y[high : high + 2])
    return float(0.5 * (upper - lower))


def measure_poiseuille(level: Level) -> dict[str, Found]:
    """Profile of speed at the end of the run, row by row."""
    result = level["run"]
    y, speed = row_means(result, result.frame("velocity_x"))
    exact = poiseuille(result.scene, y)
    fine = np.linspace(0.0, result.scene.geometry.height, 10001)
    top = float(poiseuille(result.scene, fine).max())
    return {
        "plug_speed": Found("speed of the plug", "m/s", float(speed.max()), top),
        "plug_half_width": Found(
            "half-width of the plug (faster than 99 %)",
            "m",
            _plug_half_width(y, speed),
            _plug_half_width(fine, poiseuille(result.scene, fine)),
        ),
        "profile_error": Found(
            "root mean square error of the profile over the plug's speed", "1", float(np.sqrt(np.mean((speed - exact) ** 2))) / top, 0.0
        ),
    }


@styled
def draw_poiseuille(levels: Mapping[str, Level]) -> Figure:
    """Profile of a Bingham fluid's speed between two plates, row by row, and the closed form."""
    figure = Figure(figsize=(0.6 * WIDTH, 3.0), layout="constrained")
    ax = figure.subplots()
    for marker, colour, (label, level) in zip("os^v", curve_colours(len(levels)), levels.items(), strict=False):
        y, speed = row_means(level["run"], level["run"].frame("velocity_x"))
        ax.plot(1e3 * speed, y, linestyle="", marker=marker, markersize=3, markerfacecolor="none", color=colour, label=f"spacing {label} m")
    y = np.linspace(0.0, level["run"].scene.geometry.height, 500)
    ax.plot(1e3 * poiseuille(level["run"].scene, y), y, color="black", linewidth=0.9, label="closed form")
    ax.set(xlabel="speed (mm/s)", ylabel="height (m)", xlim=(0.0, None), ylim=(0.0, y[-1]))
    ax.legend()
    return figure


# ---------------------------------------------------------------- V25: layer on an incline

STEADY = 15.0
"""Time from which the layer is steady, s; before, it comes up to speed."""


def surface_speed(result: Result) -> np.ndarray:
    """Speed (frames,) of the row that was the surface, m/s."""
    top = result.start("y0") == result.start("y0").max()
    return np.abs(result.data["velocity_x"].values[:, result.soil][:, top].astype(float)).mean(axis=1)


def measure_incline(level: Level) -> dict[str, Found]:
    """Of each run, the speed of the surface that is furthest from the closed form from ``STEADY`` on, and the profile at the end."""
    found = {}
    for name, result in level.items():
        case = f"E = {result.scene.soil.youngs_modulus / 1e3:g} MPa"
        speed = surface_speed(result)[result.data["time"].values >= STEADY]
        exact = float(incline(result.scene, np.array([column(result.scene)[1]]))[0])
        y, at_end = result.frame("y"), np.abs(result.frame("velocity_x"))
        error = float(np.sqrt(np.mean((at_end - incline(result.scene, y)) ** 2))) / exact
        worst = float(speed[np.argmax(np.abs(speed - exact))])
        text = f"worst speed of the surface, {STEADY:g} to {result.scene.duration:g} s, {case}"
        found[f"worst_speed_{name}"] = Found(text, "m/s", worst, exact)
        found[f"profile_{name}"] = Found(f"root mean square error of the profile over the plug's speed, {case}", "1", error, 0.0)
    return found


@styled
def draw_incline(levels: Mapping[str, Level]) -> Figure:
    """Speed of the surface of a Bingham layer on an incline, over the closed form, in time; dashed is the stiffer fluid."""
    figure = Figure(figsize=(WIDTH, 2.6), layout="constrained")
    ax = figure.subplots()
    for colour, (label, level) in zip(curve_colours(len(levels)), levels.items(), strict=True):
        for look, result in zip(LINE_STYLES, level.values(), strict=False):
            speed = surface_speed(result) / incline(result.scene, np.array([column(result.scene)[1]]))
            modulus = f"{result.scene.soil.youngs_modulus / 1e3:g} MPa"
            ax.plot(result.data["time"].values, speed, color=colour, linestyle=look, label=f"spacing {label} m, {modulus}")
    ax.axhline(1.0, color="black", linewidth=0.9)
    ax.set(xlabel="time (s)", ylabel="speed over closed form", xlim=(0.0, None), ylim=(0.85, 1.1))
    ax.legend(ncols=len(levels), loc="lower right")
    return figure


# ---------------------------------------------------------------- spreading columns (V7, V8)


def spread(result: Result, frame: int = -1) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the wall behind the column and height (n,) of the particles of the largest mass, m."""
    x, y = result.frame("x", frame), result.frame("y", frame)
    spacing = result.scene.numerics.spacing
    mass = largest_mass(x, y, MetricSettings().link_length * spacing)
    return result.scene.geometry.width - x[mass], y[mass]


def front(result: Result) -> float:
    """Distance of the deposit's front from the wall behind the column, m."""
    return float(spread(result)[0].max()) + 0.5 * result.scene.numerics.spacing


def height_at_wall(result: Result) -> float:
    """Largest height within three spacings of the wall behind the column, m."""
    distance, height = spread(result)
    spacing = result.scene.numerics.spacing
    return float(height[distance < 3.0 * spacing].max()) + 0.5 * spacing


def column(scene: Scene) -> tuple[float, float]:
    """Length and height of the column at the start, m."""
    length, height = np.ptp(scene.geometry.bodies[0].outline, axis=0)  # type: ignore[union-attr]
    return float(length), float(height)


# ---------------------------------------------------------------- V7: Bingham slump


def slump(scene: Scene) -> tuple[float, float]:
    """Height at the centre and reach (m) of a shallow Bingham fluid at rest with the column's volume."""
    length, height = column(scene)
    slope = 2.0 * scene.soil.cohesion_si / (scene.soil.density * GRAVITY)
    central = (1.5 * slope * length * height) ** (1.0 / 3.0)
    return central, central**2 / slope


LAYER = 0.015
"""Thickness of the sliding layer, the upper one where there are two, m."""


def deceleration(result: Result, thickness: float, first: float, last: float) -> float:
    """Deceleration (m/s2) of the upper layer of a thickness (m) between two times (s)."""
    time, y = result.data["time"].values, result.start("y0")
    upper = y > y.max() + 0.5 * result.scene.numerics.spacing - thickness
    speed = np.array([result.frame("velocity_x", frame)[upper].mean() for frame in range(time.size)])
    seen = (first - 1e-3 <= time) & (time <= last + 1e-3)
    return -float(np.polyfit(time[seen], speed[seen], 1)[0])


def traction(result: Result) -> float:
    """Stress that holds a sliding layer of fluid over the yield stress."""
    soil = result.scene.soil
    return deceleration(result, LAYER, 0.25, 0.45) * soil.density * LAYER / soil.cohesion_si


def measure_slump(level: Level) -> dict[str, Found]:
    """Reach and height at the end of the run, and what holds a layer that slides on the base."""
    result = level["run"]
    central, reach = slump(result.scene)
    return {
        "runout": Found("reach", "m", front(result), reach),
        "central_height": Found("height at the centre", "m", height_at_wall(result), central),
        "traction_on_base": Found("hold of the base on a sliding layer, over τ_y", "1", traction(level["on_base"]), 1.0),
        "traction_on_fluid": Found("hold of the fluid on a sliding layer, over τ_y", "1", traction(level["on_fluid"]), 1.0),
    }


@styled
def draw_slump(levels: Mapping[str, Level]) -> Figure:
    """Deposit of a Bingham fluid: particles of the finest level, the column at the start (dashed), and shallow theory."""
    result = list(levels.values())[-1]["run"]
    central, reach = slump(result.scene)
    length, height = column(result.scene)
    figure = Figure(figsize=(WIDTH, 1.7), layout="constrained")
    ax = figure.subplots()
    spacing = result.scene.numerics.spacing
    draw_circles(ax, 1e3 * spread(result)[0], 1e3 * spread(result)[1], 1e3 * spacing, facecolor="#d9c9a8", edgecolor="0.4", linewidth=0.1)
    x = np.linspace(0.0, reach, 400)
    ax.plot(1e3 * x, 1e3 * central * np.sqrt(np.maximum(1.0 - x / reach, 0.0)), color="black", label="shallow theory")
    ax.plot(np.array([0.0, 1, 1]) * 1e3 * length, np.array([1, 1, 0.0]) * 1e3 * height, color="black", linestyle="--", linewidth=0.8)
    for look, colour, (label, level) in zip(LINE_STYLES[1:], curve_colours(len(levels)), levels.items(), strict=False):
        ax.axvline(1e3 * front(level["run"]), color=colour, linestyle=look, label=f"front, {label}")
    ax.set(aspect="equal", xlabel="distance from the centre (mm)", ylabel="height (mm)", xlim=(0.0, 1.05e3 * max(reach, front(result))))
    ax.set_ylim(0.0, 1.1e3 * height)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=len(levels) + 1)
    return figure


# ---------------------------------------------------------------- V8: granular column

COLUMNS = ("a10", "a15", "a20", "a30", "soil2_a10", "soil2_a20")
"""The runs that are columns."""
SHARE = 0.99
"""Share of the mass within the second distance measured, which a film of single particles ahead of the deposit does not decide."""
BIN = 0.2
"""Length over which the thickness of a deposit is averaged, in widths of the column."""


def aspect_ratio(scene: Scene) -> float:
    """Height over width of the column at the start, free of rounding."""
    width, height = column(scene)
    return round(height / width, 9)


def rods_runout(aspect_ratio: float) -> float:
    """(d - d_0) / d_0 of rods from their column's height over width, at least 0.65 (Nguyen, Bui and Fukagawa 2015)."""
    return 3.25 * aspect_ratio**0.96 if aspect_ratio <= 1.5 else 3.80 * aspect_ratio**0.73


def rods_height(aspect_ratio: float) -> float:
    """Height of the rods at the wall over that of their column, at least 0.65 times as high as wide (Nguyen, Bui and Fukagawa 2015)."""
    return 1.0 / (1.42 * aspect_ratio ** (2.0 / 3.0))


def reach_of_share(result: Result, share: float = SHARE) -> float:
    """Distance from the wall behind the column that holds a share of the soil's mass, m."""
    distance = result.scene.geometry.width - result.frame("x")
    return float(np.quantile(distance, share)) + 0.5 * result.scene.numerics.spacing


def measure_granular_column(level: Level) -> dict[str, Found]:
    """Run-out over the column's width by front and by mass, the height that stays at the wall, and what holds a sliding layer."""
    fronts, masses, heights = {}, {}, {}
    for name in COLUMNS:
        result = level[name]
        (width, height), ratio = column(result.scene), aspect_ratio(result.scene)
        case = f"a = {ratio:g}, φ = {result.scene.soil.friction_angle:g}°"
        law = rods_runout(ratio)
        fronts[f"front_{name}"] = Found(f"(d - d_0)/d_0 of the front, {case}", "1", front(result) / width - 1.0, law)
        masses[f"mass99_{name}"] = Found(f"(d - d_0)/d_0 of 99 % of the mass, {case}", "1", reach_of_share(result) / width - 1.0, law)
        heights[f"height_{name}"] = Found(f"h/h_0 at the wall, {case}", "1", height_at_wall(result) / height, rods_height(ratio))
    layer = level["layer"]
    held = deceleration(layer, column(layer.scene)[1], 0.05, 0.2) / (GRAVITY * math.sin(layer.scene.soil.friction_angle_si))
    return {**fronts, **masses, **heights, "friction": Found("friction on a sliding layer over g sin φ", "1", held, 1.0)}


def thickness(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the wall behind the column (n,) and mean thickness of the deposit there (n,), in widths of the column."""
    width = column(result.scene)[0]
    distance = (result.scene.geometry.width - result.frame("x")) / width
    edges = np.arange(0.0, result.scene.geometry.width / width, BIN)
    count, _ = np.histogram(distance, edges)
    return edges[:-1] + 0.5 * BIN, count * (result.scene.numerics.spacing / width) ** 2 / BIN


@styled
def draw_granular_column(levels: Mapping[str, Level]) -> Figure:
    """Thickness of the deposits of columns of rods, in widths of the column, heights exaggerated: dashed with the second friction angle.
    Circle and triangle are height and front of the experiments, bars the distance that holds 99 % of the mass, thin lines the column."""
    figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
    axes = figure.subplots(2, 2)
    titles = []
    for ax, name in zip(axes.flat, ("a10", "a15", "a20", "a30"), strict=True):
        for colour, (label, level) in zip(curve_colours(len(levels)), levels.items(), strict=True):
            ax.plot(*thickness(level[name]), color=colour, label=label)
            ax.plot(reach_of_share(level[name]) / column(level[name].scene)[0], 0.0, marker="|", markersize=10, color=colour, clip_on=False)
        ratio = aspect_ratio(level[name].scene)
        if f"soil2_{name}" in level:
            second = level[f"soil2_{name}"]
            ax.plot(*thickness(second), color=colour, linestyle="--", label=f"{label}, φ = {second.scene.soil.friction_angle:g}°")
        ax.plot([0.0, 1.0, 1.0], [ratio, ratio, 0.0], color="black", linewidth=0.5)
        ax.plot(1.0 + rods_runout(ratio), 0.0, marker="^", color="black", clip_on=False, zorder=5)
        ax.plot(0.0, ratio * rods_height(ratio), marker="o", markersize=4, color="black", clip_on=False, zorder=5)
        ax.set(xlim=(0.0, 1.25 * (1.0 + rods_runout(ratio))), ylim=(0.0, 1.05 * ratio))
        titles.append(f"a = {ratio:g}, φ = {level[name].scene.soil.friction_angle:g}°")
    label_panels(axes.flat, titles)
    axes[0, 0].legend()
    figure.supxlabel("distance from the wall over the column's width")
    figure.supylabel("thickness over the column's width")
    return figure


# ---------------------------------------------------------------- the cases

V6 = Case(
    title="Bingham plane Poiseuille flow",
    scene="config/scenes/validation/v06_poiseuille.yaml",
    source="closed form; u = G (h y - y²/2)/μ - τ_y y/μ to the plug",
    ours="channel, fluid and pressure gradient",
    measure=measure_poiseuille,
    draw=draw_poiseuille,
    levels={
        **at_spacings({"0.05": 0.05, "0.025": 0.025}),
        "0.0125": {"numerics": {"spacing": 0.0125, "time_step": 0.005}},
        "0.00625": {"numerics": {"spacing": 0.00625, "time_step": 0.005}},
    },
    quantities={
        "plug_speed": Quantity(Kind.SPEED, 0.05, 0.15, "closed form; the wall takes the place of the layers behind it to first order"),
        "plug_half_width": Quantity(Kind.LENGTH, 0.05, 0.30, "closed form; known to a spacing"),
        "profile_error": Quantity(Kind.PROFILE, 0.05, 0.15, "closed form; root mean square over the channel, over the plug's speed"),
    },
)


def rectangle(left: float, right: float, height: float) -> dict[str, Any]:
    """Geometry of one body on the base, m."""
    return {"bodies": [{"kind": "polygon", "points": [[left, 0.0], [right, 0.0], [right, height], [left, height]]}]}


SLIDING = {
    "duration": 0.5,
    "geometry": {"width": 0.05, **rectangle(0.0, 0.05, 0.015)},
    "walls": {"sides": "periodic"},
    "soil": {"viscosity": 0.01},
    "initial_velocity": {"along": "y", "position": [0.0], "x": [1.0], "y": [0.0]},
    "outputs": {"frame_interval": 0.01},
}
"""15 mm of nearly inviscid fluid that slide at 1 m/s on the base."""
V7 = Case(
    title="Slump of a Bingham fluid",
    scene="config/scenes/validation/v07_bingham_slump.yaml",
    source="shallow theory (Liu and Mei 1989); h² = h_c² - 2 τ_y x/(ρ g)",
    reference="formula",
    ours="fluid and its first shape; the sliding layers and their hold are a closed form of our own",
    measure=measure_slump,
    draw=draw_slump,
    # The layers were added after the first runs of the slump, to see why it runs too far.  The yield stress should hold both.
    runs={
        "run": {},
        "on_base": SLIDING,
        "on_fluid": {
            **SLIDING,
            "geometry": {"width": 0.05, **rectangle(0.0, 0.05, 0.03)},
            "initial_velocity": {"along": "y", "position": [0.0149, 0.0151], "x": [0.0, 1.0], "y": [0.0, 0.0]},
        },
    },
    levels=at_spacings({"5 mm": 0.005, "2.5 mm": 0.0025, "1.25 mm": 0.00125}),
    # The tolerance of the base's hold was tightened with the no-slip wall.
    quantities={
        "runout": Quantity(
            Kind.RUNOUT, 0.10, 0.15, "the theory is for shallow flows; this one is at rest 4.6 times as long as it was high"
        ),
        "central_height": Quantity(Kind.HEIGHT, 0.30, 0.40, "the theory is for shallow flows; codes accept 25 to 30 %"),
        "traction_on_base": Quantity(
            Kind.TRACTION, 0.10, 0.15, "momentum of the layer between 0.25 and 0.45 s; a wall without slip holds it as fluid does"
        ),
        "traction_on_fluid": Quantity(
            Kind.TRACTION, 0.25, 0.50, "momentum of the layer; particles at the interface differ by tens of per cent"
        ),
    },
)
SECOND_SOIL = {"soil": {"density": 2040.0, "youngs_modulus": 5840.0, "poisson_ratio": 0.3, "friction_angle": 21.9}}
TWICE_AS_HIGH = {"geometry": rectangle(1.5, 1.6, 0.2)}
FIT = "fit of experiments; friction angle known within 2 degrees"
V8 = Case(
    title="Collapse of a column of rods in plane strain",
    scene="config/scenes/validation/v08_granular_column.yaml",
    source=(
        "experiments with aluminium rods (Nguyen, Bui and Fukagawa 2015): (d - d_0)/d_0 = 3.25 a^0.96 to a = 1.5, 3.80 a^0.73 above, "
        "h_0/h = 1.42 a^(2/3)"
    ),
    reference="published",
    ours="stiffness, walls, and the friction angle between two published ones; the sliding layer is a closed form of our own",
    measure=measure_granular_column,
    draw=draw_granular_column,
    # The friction angle of the rods is not known: 19.8 degrees is that of Bui et al. (2008) for aluminium rods, 21.9 that of Nguyen et al.
    # (2017).  The runs soil2 are of the second set; they show what the angle does.
    runs={
        "a10": {},
        "a15": {"geometry": rectangle(1.5, 1.6, 0.15)},
        "a20": TWICE_AS_HIGH,
        "a30": {"geometry": rectangle(1.5, 1.6, 0.3)},
        "soil2_a10": SECOND_SOIL,
        "soil2_a20": {**SECOND_SOIL, **TWICE_AS_HIGH},
        # A layer of the same grains that slides on the base at 1 m/s.  The closed form was g tan φ until the layer had been measured on a
        # no-slip base: soil that does not dilate mobilises sin φ on the plane along which it is sheared.
        "layer": {
            "duration": 0.25,
            "geometry": {"width": 0.2, **rectangle(0.0, 0.2, 0.05)},
            "walls": {"sides": "periodic"},
            "initial_velocity": {"along": "y", "position": [0.0], "x": [1.0], "y": [0.0]},
            "outputs": {"frame_interval": 0.01},
        },
    },
    levels=at_spacings({"10 mm": 0.01, "5 mm": 0.005, "2.5 mm": 0.0025}),
    # The two fits that the source gives for d differ by up to 4 %; 15 % allows for that, for a scatter of the tests of some 10 % and for
    # the friction angle.  The last hundredth of the area of a deposit that ends in a wedge of 8 degrees is the last tenth of its length:
    # the distance that holds 99 % of the mass falls that much short of the law for the front.
    quantities={
        **{f"front_{name}": Quantity(Kind.RUNOUT, 0.15, 0.25, FIT) for name in COLUMNS},
        **{
            f"mass99_{name}": Quantity(Kind.RUNOUT, 0.25, 0.35, "law of the front; 1 % of the mass is the last tenth of the length")
            for name in COLUMNS
        },
        **{f"height_{name}": Quantity(Kind.HEIGHT, 0.15, 0.25, FIT) for name in COLUMNS},
        "friction": Quantity(Kind.TRACTION, 0.10, 0.20, "Coulomb friction on the whole layer; closed form"),
    },
)
STEADY_FLOW = Quantity(Kind.SPEED, 0.03, 0.06, "closed form; no part of the flow may gather errors over 60 s")
STEADY_PROFILE = Quantity(Kind.PROFILE, 0.05, 0.15, "closed form; root mean square over the layer, over the plug's speed, as V6")
# Added after a layer of soft fluid had been seen to speed up without end (+23 % after 55 s at 0.05 m), and after the cause had been removed
# in runs of 0.1, 0.05 and 0.025 m that told the speeds to expect.  The 3 % had been asked for before.
V25 = Case(
    title="Bingham layer on an incline",
    scene="config/scenes/validation/v25_bingham_incline.yaml",
    source="closed form; u = (G (H y - y²/2) - τ_y y)/μ to the plug, G = ρ g sin θ, steady for as long as it flows",
    ours="layer, fluid and incline; the time, in which the surface of the softer fluid travels 88 times the layer's thickness",
    measure=measure_incline,
    draw=draw_incline,
    runs={"run": {}, "stiff": {"soil": {"youngs_modulus": 2.0e4}}},
    levels=at_spacings({"0.1": 0.1, "0.05": 0.05, "0.025": 0.025}),
    quantities={
        "worst_speed_run": STEADY_FLOW,
        "profile_run": STEADY_PROFILE,
        "worst_speed_stiff": STEADY_FLOW,
        "profile_stiff": STEADY_PROFILE,
    },
)
