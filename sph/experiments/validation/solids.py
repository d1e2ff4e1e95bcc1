"""V4, V5 and V12: bodies of elastic soil that swing, meet and slide."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from sph.experiments.validation.level import Found, Level, Result
from sph.figures.profile import draw_circles
from sph.figures.style import GREY, LINE_STYLES, WIDTH, curve_colours, label_panels, styled
from sph.measures.linked import linked_sets
from sph.measures.metrics import energy_gap
from sph.output.run import Run
from sph.scene.geometry import RingBody
from sph.scene.schema import Scene
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles

# ---------------------------------------------------------------- V4: plate

MODE = 1.875
"""kL of the first mode of a clamped-free beam."""


def plate_period(scene: Scene) -> float:
    """Period of the first mode by thin-plate theory, s."""
    length, thickness = np.ptp(scene.geometry.bodies[0].outline, axis=0)  # type: ignore[union-attr]
    soil = scene.soil
    stiffness = 1e3 * soil.youngs_modulus / (1.0 - soil.poisson_ratio**2)
    return float(2.0 * math.pi / math.sqrt(stiffness * thickness**2 * (MODE / length) ** 4 / (12.0 * soil.density)))


def swings(time: np.ndarray, displacement: np.ndarray) -> float:
    """Mean period (s) of a swing (n,) that starts at rest in the middle: the last whole one's end over their number; NaN without one."""
    up = np.flatnonzero((displacement[:-1] < 0.0) & (displacement[1:] >= 0.0))
    if up.size == 0:
        return math.nan
    last = up[-1]
    share = -displacement[last] / (displacement[last + 1] - displacement[last])
    return float(time[last] + share * (time[last + 1] - time[last])) / up.size


def _tip(result: Result) -> tuple[np.ndarray, np.ndarray]:
    return result.data["sample_time"].values, result.data["probe_displacement_y"].values[:, 0]


def measure_plate(level: Level) -> dict[str, Found]:
    """Period of the tip, for small and for large swings."""
    return {
        f"period_{name}": Found(f"period, {name} swings", "s", swings(*_tip(result)), plate_period(result.scene))
        for name, result in level.items()
    }


@styled
def draw_plate(levels: Mapping[str, Level]) -> Figure:
    """Tip of a clamped plate in its first mode, small and large swings; vertical lines are whole periods of thin-plate theory."""
    figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
    axes = figure.subplots(1, 2)
    for ax, name in zip(axes, ("small", "large"), strict=True):
        for look, colour, (label, level) in zip(LINE_STYLES, curve_colours(len(levels)), levels.items(), strict=False):
            time, tip = _tip(level[name])
            ax.plot(time, 1e3 * tip, color=colour, linestyle=look, label=label)
        for whole in (1, 2):
            ax.axvline(whole * plate_period(level[name].scene), color="black", linewidth=0.7)
        ax.axhline(0.0, color=GREY, linewidth=0.5)
        ax.set(xlabel="time (s)", ylabel="displacement of the tip (mm)", xlim=(0.0, time[-1]))
    label_panels(axes, ["small", "large"])
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(levels))
    return figure


# ---------------------------------------------------------------- V5: rings

LINK = 1.7
"""Particles nearer than this many spacings belong to one piece."""


def momentum(scene: Scene, result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Linear momentum x, y and angular momentum about the box's middle (kg/s, kg m/s for a metre), of the soil, at start and end."""
    particles = place_particles(scene)
    assert result.restart is not None
    soil = slice(0, particles.n_soil)
    middle = 0.5 * scene.geometry.width, 0.5 * scene.geometry.height

    def total(state: Mapping[str, np.ndarray]) -> np.ndarray:
        x, y, vx, vy = (np.asarray(state[name])[soil] for name in ("x", "y", "vx", "vy"))
        m = particles.mass[soil]
        return np.array([m @ vx, m @ vy, m @ ((x - middle[0]) * vy - (y - middle[1]) * vx)])

    end = {name: result.restart[name].values for name in ("x", "y", "vx", "vy")}
    return total(initial_state(particles, scene)._asdict()), total(end)


def measure_rings(level: Level) -> dict[str, Found]:
    """Pieces, shape, momentum and energy after the rings have met."""
    result = level["run"]
    scene = result.scene
    x, y = result.frame("x"), result.frame("y")
    pieces = int(linked_sets(x, y, LINK * scene.numerics.spacing).max()) + 1
    ring = scene.geometry.bodies[0]  # type: ignore[union-attr]
    assert isinstance(ring, RingBody)
    left = result.start("x0") < 0.5 * scene.geometry.width
    width = 0.5 * (np.ptp(x[left]) + np.ptp(y[left])) + scene.numerics.spacing
    start, end = momentum(scene, result)
    of_one_ring = 0.5 * result.start("mass").sum() * abs(scene.initial_velocity.x[0])  # type: ignore[union-attr]
    return {
        "pieces": Found("pieces after the bounce", "1", float(pieces), 2.0),
        "ring_strain": Found("mean width of a ring at the end", "m", float(width), 2.0 * ring.outer_radius),
        "momentum_drift": Found("change of linear momentum over one ring's", "1", float(np.abs(end - start)[:2].max() / of_one_ring), 0.0),
        "energy_error": Found("gap in the energy budget over its parts", "1", energy_gap(Run(result.data)), 0.0),
    }


@styled
def draw_rings(levels: Mapping[str, Level]) -> Figure:
    """Two rubber rings that meet and part, at six times, finest level; the shade is the mean stress."""
    level = list(levels.values())[-1]
    result = level["run"]
    frames = np.linspace(0, result.data.sizes["frame"] - 1, 6).round().astype(int)
    figure = Figure(figsize=(WIDTH, 3.0), layout="compressed")
    axes = figure.subplots(2, 3, sharex=True, sharey=True)
    stress = [1e-3 * (result.frame("stress_xx", f) + result.frame("stress_yy", f)) / 2 for f in frames]
    bound = float(np.percentile(np.abs(np.concatenate(stress)), 99)) or 1.0
    for ax, frame, values in zip(axes.flat, frames, stress, strict=True):
        style = {"cmap": "RdBu_r", "clim": (-bound, bound), "linewidth": 0}
        x, y = result.frame("x", frame), result.frame("y", frame)
        circles = draw_circles(ax, 1e3 * x, 1e3 * y, 1.2e3 * result.scene.numerics.spacing, array=values, **style)
        ax.set(aspect="equal", xlim=(-100.0, 300.0), ylim=(-10.0, 110.0))
    label_panels(axes.flat, [f"{1e3 * t:.2f} ms" for t in result.data["time"].values[frames]])
    for ax in axes[-1]:
        ax.set_xlabel("x (mm)")
    for ax in axes[:, 0]:
        ax.set_ylabel("y (mm)")
    figure.colorbar(circles, ax=list(axes.flat), label="mean stress in the plane (kPa)", pad=0.015, fraction=0.03, extend="both")
    return figure


# ---------------------------------------------------------------- V12: incline


def incline_slip(scene: Scene, time: np.ndarray | float) -> np.ndarray | float:
    """Slip (m) of a rigid block on the scene's incline at times (s) after gravity's ramp began."""
    theta, ramp = math.radians(scene.gravity.inclination), scene.gravity.ramp
    coefficient = 0.0 if scene.walls.friction is None else scene.walls.friction.base
    acceleration = scene.gravity.acceleration * max(math.sin(theta) - coefficient * math.cos(theta), 0.0)
    late = np.maximum(np.asarray(time) - ramp, 0.0)
    early = np.minimum(np.asarray(time), ramp)
    return acceleration * (early**3 / (6.0 * ramp) + ramp * late / 2.0 + late**2 / 2.0)


def measure_incline(level: Level) -> dict[str, Found]:
    """Slip of the block's mean after the run."""
    found = {}
    free = float(incline_slip(level["smooth"].scene, level["smooth"].data["time"].values[-1]))
    for name, result in level.items():
        slip = -float(result.frame("displacement_x").mean())
        reference = float(incline_slip(result.scene, result.data["time"].values[-1]))
        if reference > 0.0:
            found[f"slip_{name}"] = Found(f"slip, {name}", "m", slip, reference)
        else:
            found[f"slip_{name}"] = Found(f"slip over that of the smooth block, {name}", "1", slip / free, 0.0)
    return found


@styled
def draw_incline(levels: Mapping[str, Level]) -> Figure:
    """Slip of a block on an incline of 30 degrees without friction, with less and with more friction than tan θ (lines: closed form)."""
    figure = Figure(figsize=(0.6 * WIDTH, 2.9), layout="constrained")
    ax = figure.subplots()
    for result in next(iter(levels.values())).values():
        fine, friction = np.linspace(0.0, result.scene.duration, 100), result.scene.walls.friction
        exact = incline_slip(result.scene, fine)
        ax.plot(fine, exact, color="black", linewidth=0.7)
        name = f"μ = {0.0 if friction is None else friction.base:g}"
        ax.annotate(name, (fine[-1], float(np.max(exact))), xytext=(5, -3), textcoords="offset points")
    for marker, colour, (label, level) in zip("os^", curve_colours(len(levels)), levels.items(), strict=False):
        for number, result in enumerate(level.values()):
            time = result.data["time"].values
            slip = [-result.frame("displacement_x", frame).mean() for frame in range(time.size)]
            look = {"marker": marker, "markersize": 4, "markerfacecolor": "none", "color": colour}
            ax.plot(time, slip, linestyle="", label="" if number else label, **look)
    ax.set(xlabel="time (s)", ylabel="slip (m)", xlim=(0.0, 1.15 * time[-1]))
    ax.legend(title="spacing")
    return figure
