"""V20: columns with water, whose effective stress has a closed form."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from cases.case import Case, Found, Kind, Level, Quantity, Result, at_spacings
from cases.columns import SOFT_COLUMN, row_means
from sph.figures.style import WIDTH, curve_colours, styled
from sph.scene.gravity import GRAVITY

COMPARED = ("surface", "half", "carried", "ratio", "soft")
"""Runs whose stress is compared with the closed form."""


def effective_stress(result: Result, y: np.ndarray) -> np.ndarray:
    """Vertical effective stress (n,) at heights (n,) of a column at rest, Pa, compression positive: rho g z - u."""
    scene, height = result.scene, result.scene.geometry.height
    weight = scene.soil.density * GRAVITY * (height - y)
    water = scene.water
    assert water is not None
    if water.r_u is not None:
        return (1.0 - water.r_u) * weight
    assert water.level is not None
    above_ground = max(water.level - height, 0.0)
    return weight - 1e3 * water.unit_weight * (np.maximum(water.level - y, 0.0) - above_ground)


def _mean_ratio(result: Result) -> float:
    """Mean of the vertical effective stress over its closed form, in the inner half of the column."""
    y = result.start("y0")
    inner = np.abs(y / result.scene.geometry.height - 0.5) <= 0.25
    return float((-result.frame("stress_yy") / effective_stress(result, y))[inner].mean())


def measure_wet_columns(level: Level) -> dict[str, Found]:
    """Effective stress over its closed form; what standing water adds, and that of soil as heavy as water, over rho g H."""
    found = {name: Found(f"mean of σ'_yy/(ρ g z - u), {name}", "1", _mean_ratio(level[name]), 1.0) for name in COMPARED}

    def over_weight(result: Result, values: np.ndarray) -> float:
        return float(np.abs(values).max() / (result.scene.soil.density * GRAVITY * result.scene.geometry.height))

    surface, flooded, neutral = level["surface"], level["flooded"], level["neutral"]
    added = over_weight(surface, flooded.frame("stress_yy") - surface.frame("stress_yy"))
    found["flooded"] = Found("largest change of σ'_yy/(ρ g H) by 5 m of standing water", "1", added, 0.0)
    floating = max(over_weight(neutral, neutral.frame(f"stress_{axes}")) for axes in ("xx", "yy", "zz", "xy"))
    found["neutral"] = Found("largest effective stress over ρ g H of soil as heavy as water", "1", floating, 0.0)
    return found


@styled
def draw_wet_columns(levels: Mapping[str, Level]) -> Figure:
    """Vertical effective stress against height in columns with water at the finest resolution: means over rows, and the closed form."""
    figure = Figure(figsize=(0.65 * WIDTH, 3.2), layout="constrained")
    ax = figure.subplots()
    level = list(levels.values())[-1]
    for colour, name in zip(curve_colours(len(COMPARED)), COMPARED, strict=True):
        result = level[name]
        height, mean = row_means(result, -1e-3 * result.frame("stress_yy"))
        ax.plot(mean, height, color=colour, linestyle="", marker=".", markersize=3, label=name)
        ax.plot(1e-3 * effective_stress(result, height), height, color="black", linewidth=0.7)
    ax.set(xlabel="vertical effective stress, compression (kPa)", ylabel="height (m)", xlim=(0.0, None))
    ax.legend()
    return figure


COLUMN = Quantity(Kind.STRESS, 0.02, 0.05, "closed form; mean over the inner half of the column, as V1")
V20 = Case(
    title="Column with water",
    scene="config/scenes/validation/v20_wet_column.yaml",
    source="equilibrium; effective stress σ'_yy = ρ g z - u (Terzaghi 1943)",
    ours="column, soil and levels of the water",
    measure=measure_wet_columns,
    draw=draw_wet_columns,
    runs={
        "surface": {},
        "flooded": {"water": {"level": 25.0}},
        "half": {"water": {"level": 10.0}},
        "carried": {"water": {"pressure": "carried"}},
        "ratio": {"water": {"level": None, "r_u": 0.4}},
        "neutral": {"soil": {"density": 1000.0}},
        "soft": SOFT_COLUMN,
    },
    levels=at_spacings({"2 m": 2.0, "1 m": 1.0, "0.5 m": 0.5}),
    quantities={
        **dict.fromkeys(("surface", "half", "carried", "ratio"), COLUMN),
        "soft": Quantity(
            Kind.STRESS, 0.03, 0.06, "as the stiff column, and 1 % for the settlement, by which the surface sinks below the water"
        ),
        "flooded": Quantity(
            Kind.STRESS, 1.0e-6, 1.0e-6, "standing water changes no effective stress; rounding and the stored single precision"
        ),
        "neutral": Quantity(Kind.STRESS, 1.0e-3, 1.0e-3, "soil as heavy as water floats in it: no effective stress, over ρ g H"),
    },
)
