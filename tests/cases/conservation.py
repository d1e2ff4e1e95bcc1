"""V15: what a closed system keeps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from cases.case import Case, Found, Kind, Level, Quantity, at_time_steps
from cases.solids import momentum
from sph.figures.style import LINE_STYLES, WIDTH, curve_colours, label_panels, styled
from sph.measures.metrics import energy_gap
from sph.output.run import Run


def measure_conservation(level: Level) -> dict[str, Found]:
    """Momentum of two blocks that break on each other, energy budgets of them and of the paper's collapse."""
    blocks = level["blocks"]
    start, end = momentum(blocks.scene, blocks)
    table = blocks.scene.initial_velocity
    assert table is not None
    mass, height = 0.5 * blocks.start("mass").sum(), blocks.start("y0")
    one_block = mass * np.hypot(table.x[0], table.y[0])
    arm = 0.25 * (height.max() - height.min())
    drift = np.abs(end - start)
    return {
        "linear_momentum": Found("change of linear momentum over one block's", "1", float(drift[:2].max() / one_block), 0.0),
        "angular_momentum": Found("change of angular momentum over one block's", "1", float(drift[2] / (one_block * arm)), 0.0),
        "energy_blocks": Found("gap in the energy budget over its parts, blocks", "1", energy_gap(Run(blocks.data)), 0.0),
        "energy_paper": Found(
            "gap in the energy budget over its parts, the paper's collapse", "1", energy_gap(Run(level["paper"].data)), 0.0
        ),
        "energy_soft": Found("the same of soil a hundred times softer", "1", energy_gap(Run(level["soft"].data)), 0.0),
    }


@styled
def draw_conservation(levels: Mapping[str, Level]) -> Figure:
    """Where the energy goes: two blocks of weak soil that collide, and the paper's slope at S_R = 0.10; finest level."""
    level = list(levels.values())[-1]
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    axes = figure.subplots(1, 2)
    names = ("kinetic_energy", "elastic_energy", "potential_energy", "dissipated_energy", "shaking_work")
    for ax, result in zip(axes, (level["blocks"], level["paper"]), strict=True):
        time = result.data["sample_time"].values
        for look, colour, name in zip(LINE_STYLES, curve_colours(len(names)), names, strict=False):
            ax.plot(time, 1e-6 * result.data[name].values, color=colour, linestyle=look, label=name.replace("_", " "))
        ax.set(xlabel="time (s)", ylabel="energy (MJ/m)", xlim=(0.0, time[-1]))
    label_panels(axes, ["two blocks", "the paper's slope"])
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return figure


COLLAPSE: dict[str, Any] = {
    "duration": 15.0,
    "geometry": {"shape": "slope"},
    "walls": {"base": "fixed", "sides": "fixed"},
    "soil": {"cohesion": 150.0, "youngs_modulus": 1.675e6},
    "coupling": {"S_R": 0.1},
    "gravity": {"acceleration": 9.81, "ramp": 1.0, "duration": 3.0, "damping": 20.0},
    "damping": {"ratio": 0.02, "frequencies": [1.0, 5.6]},
    "initial_velocity": None,
    "motion": {"kind": "tapered_sine"},
    "numerics": {"smoothing_ratio": 2.3},
}
BUDGET = Quantity(Kind.ENERGY, 0.001, 0.005, "time integration; over the largest of the sums of energies")
V15 = Case(
    title="Momentum and energy",
    scene="config/scenes/validation/v15_conservation.yaml",
    source="conservation",
    ours="the blocks; the other scene is that of the paper",
    measure=measure_conservation,
    draw=draw_conservation,
    size="numerics.time_step",
    runs={
        "blocks": {},
        "paper": COLLAPSE,
        # The soft twin, a hundred times softer; its tolerance, that of the stiff slope, was written before it was run.
        "soft": {**COLLAPSE, "soil": {"cohesion": 150.0, "youngs_modulus": 1.675e4}},
    },
    levels=at_time_steps({"1e-3 s": 1.0e-3, "5e-4 s": 5.0e-4, "2.5e-4 s": 2.5e-4}),
    quantities={
        "linear_momentum": Quantity(Kind.MOMENTUM, 1.0e-9, 1.0e-9, "rounding; over the momentum of one block"),
        "angular_momentum": Quantity(Kind.MOMENTUM, 0.02, 0.02, "forces of a pair are not central; over the angular momentum of one block"),
        **dict.fromkeys(("energy_blocks", "energy_paper", "energy_soft"), BUDGET),
    },
)
