"""V11, V13 and V14: a rigid block and single elements of soil."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from cases.case import COMPUTATION, Case, Found, Kind, Level, Quantity, Result, at_time_steps
from sph.figures.style import GREY, WIDTH, curve_colours, label_panels, styled
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene
from sph.solver.physics.elasticity import Deviator
from sph.solver.physics.mohr_coulomb import MohrCoulomb, make_mohr_coulomb
from sph.solver.physics.yield_surface import limit_tension, return_factor, strength
from sph.stability.newmark import sliding_block

# ---------------------------------------------------------------- V11: Newmark block

PULSE = (0.6, 0.3, 0.2)
"""Acceleration and yield acceleration over gravity, and duration (s), of the rectangular pulse."""
SIDES = 1e-9
"""Duration of the pulse's sides, s."""
TRAIN = (1.0, 0.5, 10)
"""Frequency (Hz), yield over peak acceleration and cycles of the train of sines."""


def rectangular_pulse() -> tuple[np.ndarray, np.ndarray]:
    """Times and accelerations of the pulse."""
    peak, _, length = PULSE
    return np.array([0.0, SIDES, length, length + SIDES, 4.0 * length]), GRAVITY * np.array([0.0, peak, peak, 0.0, 0.0])


def sine_train(step: float = 1e-3) -> tuple[np.ndarray, np.ndarray]:
    """Times (s) and accelerations of the train of sines, peak 1 m/s2."""
    frequency, _, cycles = TRAIN
    time = np.arange(round(cycles / frequency / step) + 1) * step
    return time, np.sin(2.0 * np.pi * frequency * time)


def slip_in_one_cycle(frequency: float, ratio: float) -> float:
    """Slip (m) in a cycle of a sine of 1 m/s2 with yield over peak acceleration ``ratio``, for a block that stops within the cycle.

    It starts at sin(theta_0) = ratio; v = [cos(theta_0) - cos(theta) - ratio (theta - theta_0)] / omega is zero again at theta_1,
    found by bisection; the slip is the integral of v from theta_0 to theta_1.  ValueError if it does not stop within the cycle.
    """
    omega, first = 2.0 * math.pi * frequency, math.asin(ratio)

    def speed(angle: float) -> float:
        return math.cos(first) - math.cos(angle) - ratio * (angle - first)

    low, high = math.pi - first, 2.0 * math.pi + first
    if speed(high) > 0.0:
        raise ValueError(f"ratio: with {ratio} the block does not stop within a cycle")
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if speed(middle) > 0.0 else (low, middle)
    turn = low - first
    return (turn * math.cos(first) - math.sin(low) + math.sin(first) - 0.5 * ratio * turn**2) / omega**2


def measure_newmark(level: Level) -> dict[str, Found]:
    """Permanent slip under a rectangular pulse and a train of sines."""
    peak, resistance, length = PULSE
    pulse = GRAVITY * peak * length**2 * (peak / resistance - 1.0) / 2.0
    frequency, ratio, cycles = TRAIN
    return {
        "pulse": Found("slip under a rectangular pulse", "m", sliding_block(*rectangular_pulse(), resistance * GRAVITY).permanent, pulse),
        "sine_train": Found(
            "slip under ten sines", "m", sliding_block(*sine_train(), ratio).permanent, cycles * slip_in_one_cycle(frequency, ratio)
        ),
    }


@styled
def draw_newmark(levels: Mapping[str, Level]) -> Figure:
    """Slip of a Newmark block under a rectangular pulse and a train of sines; horizontal lines are the closed forms."""
    figure = Figure(figsize=(WIDTH, 2.6), layout="constrained")
    axes = figure.subplots(1, 2)
    frequency, ratio, cycles = TRAIN
    time, acceleration = rectangular_pulse()
    fine = np.unique(np.concatenate([time, np.linspace(0.0, time[-1], 400)]))
    cases = (
        (fine, np.interp(fine, time, acceleration), PULSE[1] * GRAVITY, measure_newmark({})["pulse"].reference),
        (*sine_train(), ratio, cycles * slip_in_one_cycle(frequency, ratio)),
    )
    for ax, (t, a, resistance, reference) in zip(axes, cases, strict=True):
        ax.plot(t, 1e3 * sliding_block(t, a, resistance).displacement, color=curve_colours(1)[0])
        ax.axhline(1e3 * reference, color="black", linewidth=0.7, linestyle="--")
        ax.set(xlabel="time (s)", ylabel="slip (mm)", xlim=(0.0, t[-1]), ylim=(0.0, None))
    label_panels(axes, ["rectangular pulse, 0.6 g, 0.2 s, yield 0.3 g", "ten sines, 1 Hz, 1 m/s², yield 0.5 m/s²"])
    return figure


# ---------------------------------------------------------------- V13: simple shear


def strengths(scene: Scene) -> tuple[float, float]:
    """Shear strength (Pa) of the solid and the fluid state at the scene's pressure."""
    pressure = 1e3 * scene.gravity.initial_stress.pressure  # type: ignore[union-attr]
    soil, ratio = scene.soil, scene.coupling.S_R
    surfaces = (
        make_mohr_coulomb(soil.cohesion_si, soil.friction_angle_si),
        make_mohr_coulomb(ratio * soil.cohesion_si, ratio * soil.friction_angle_si),
    )
    return tuple(float(strength(surface, pressure)) for surface in surfaces)  # type: ignore[return-value]


def shear_stress(scene: Scene, time: np.ndarray) -> np.ndarray:
    """Shear stress (Pa) at times (n,) in simple shear at the scene's rate: elastic, then softening."""
    solid, fluid = strengths(scene)
    rate = scene.prescribed_velocity_gradient.xy  # type: ignore[union-attr]
    elastic = scene.soil.shear_modulus_si * rate * time
    failed = solid / (scene.soil.shear_modulus_si * rate)
    carried = np.maximum(elastic, solid) if scene.coupling.solid_after_failure == "elastic" else solid
    after = fluid + (carried - fluid) * np.exp(-scene.coupling.gamma * np.maximum(time - failed, 0.0))
    return np.where(time < failed, elastic, after)


def _mean_shear(result: Result) -> tuple[np.ndarray, np.ndarray]:
    return result.data["time"].values, result.data["stress_xy"].values[:, result.soil].astype(float).mean(axis=1)


def measure_simple_shear(level: Level) -> dict[str, Found]:
    """Strength at and after failure, and what a turn leaves."""
    sheared, elastic, spun = level["shear"], level["elastic"], level["spin"]
    solid, fluid = strengths(sheared.scene)
    gamma = sheared.scene.coupling.gamma
    time, stress = _mean_shear(sheared)
    t_f = float(np.nanmean(sheared.data["t_f"].values))
    first = int(np.argmax(time > t_f))
    peak = fluid + (stress[first] - fluid) * math.exp(gamma * (time[first] - t_f))
    later = int(np.argmax(time > t_f + 1.0 / gamma))
    _, carried = _mean_shear(elastic)
    xx, yy, zz, xy = (spun.frame(f"stress_{name}") for name in ("xx", "yy", "zz", "xy"))
    deviator = np.hypot(0.5 * (xx - yy), xy).max() / spun.scene.soil.shear_modulus_si
    pressure = -(xx + yy + zz).mean() / 3.0
    start = 1e3 * spun.scene.gravity.initial_stress.pressure  # type: ignore[union-attr]
    return {
        "peak_strength": Found("shear strength at failure", "Pa", float(peak), solid),
        "strength_after": Found("shear strength 1/γ later", "Pa", float(stress[later]), float(shear_stress(sheared.scene, time[later]))),
        "elastic_after": Found(
            "the same of a solid state that is elastic after failure",
            "Pa",
            float(carried[later]),
            float(shear_stress(elastic.scene, time[later])),
        ),
        "spin_deviator": Found("deviator after a turn of 0.6 rad over G", "1", float(deviator), 0.0),
        "spin_pressure": Found(
            "change of pressure in that turn over K", "1", float((pressure - start) / spun.scene.soil.bulk_modulus_si), 0.0
        ),
    }


@styled
def draw_simple_shear(levels: Mapping[str, Level]) -> Figure:
    """Shear stress of an element in simple shear at constant pressure, with either solid state of failed soil."""
    figure = Figure(figsize=(0.6 * WIDTH, 2.8), layout="constrained")
    ax = figure.subplots()
    for run, style in (("shear", "-"), ("elastic", "--")):
        for marker, colour, (label, level) in zip("os^", curve_colours(len(levels)), levels.items(), strict=False):
            time, stress = _mean_shear(level[run])
            named = label if run == "shear" else None
            ax.plot(time, 1e-3 * stress, linestyle="", marker=marker, markersize=3, markerfacecolor="none", color=colour, label=named)
        fine = np.linspace(0.0, time[-1], 2000)
        law = level[run].scene.coupling.solid_after_failure.replace("_", "-")
        ax.plot(fine, 1e-3 * shear_stress(level[run].scene, fine), style, color="black", linewidth=0.8, label=f"closed form, {law}")
    ax.set(xlabel="time (s)", ylabel="shear stress (kPa)", xlim=(0.0, time[-1]), ylim=(0.0, None))
    ax.legend()
    return figure


# ---------------------------------------------------------------- V14: Mohr-Coulomb return

STRESSES = 100_000
"""Random stresses that are returned."""


def returned(surface: MohrCoulomb, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Random pressures and deviators (4, n) of a size (Pa), as in ``elasticity``, and the same after the return."""
    trial = np.random.default_rng(14).normal(0.0, size, (4, STRESSES))
    after = trial.copy()
    for i, (p, *deviator) in enumerate(trial.T):
        after[0, i] = limit_tension(surface, p)
        after[1:, i] *= return_factor(surface, after[0, i], Deviator(*deviator))
    return trial, after


def measure_return(level: Level) -> dict[str, Found]:
    """Surface, direction of the deviator and apex after the return, from the principal stresses in the plane."""
    soil = level["run"].scene.soil
    surface = make_mohr_coulomb(soil.cohesion_si, soil.friction_angle_si)
    trial, after = returned(surface, 5e6)
    p, d, q, z = after
    radius, mean = np.hypot(d, q), -p - 0.5 * z
    cohesive = soil.cohesion_si * math.cos(soil.friction_angle_si)
    excess = (radius + mean * math.sin(soil.friction_angle_si) - cohesive) / cohesive
    size = np.linalg.norm(trial[1:], axis=0) * np.linalg.norm(after[1:], axis=0)
    cross = np.linalg.norm(np.cross(trial[1:].T, after[1:].T), axis=1)
    turn = np.divide(cross, size, out=np.zeros_like(cross), where=size > 0.0)
    apex = soil.cohesion_si / math.tan(soil.friction_angle_si)
    return {
        "overshoot": Found("largest excess over the surface, over c cos φ", "1", float(max(excess.max(), 0.0)), 0.0),
        "turn": Found("largest turn of the deviator", "rad", float(turn.max()), 0.0),
        "apex": Found("largest mean tension over that of the apex", "1", float(-p.min() / apex), 1.0),
    }


@styled
def draw_return(levels: Mapping[str, Level]) -> Figure:
    """Random stresses before (grey) and after (dark) the return to the Mohr-Coulomb surface (line)."""
    scene = next(iter(levels.values()))["run"].scene
    surface = make_mohr_coulomb(scene.soil.cohesion_si, scene.soil.friction_angle_si)
    trial, after = (1e-6 * stresses[:, :3000] for stresses in returned(surface, 5e6))
    figure = Figure(figsize=(0.6 * WIDTH, 3.0), layout="constrained")
    ax = figure.subplots()
    for (p, d, q, z), colour, name in ((trial, "0.75", "before"), (after, curve_colours(1)[0], "after")):
        ax.plot(p + 0.5 * z, np.hypot(d, q), linestyle="", marker=".", markersize=2, color=colour, label=name)
    mean = np.array([-1e-6 * surface.tension_limit, 15.0])
    ax.plot(mean, 1e-6 * surface.cohesion_term + mean * surface.sine, color="black", linewidth=0.8, label="surface")
    ax.axvline(0.0, color=GREY, linewidth=0.5)
    ax.set(xlabel="mean pressure in the plane (MPa)", ylabel="radius of Mohr's circle (MPa)", xlim=(-8.0, 15.0), ylim=(0.0, 15.0))
    ax.legend(markerscale=3)
    return figure


# ---------------------------------------------------------------- the cases

V11 = Case(
    title="Newmark sliding block",
    scene="config/scenes/paper.yaml",
    by=COMPUTATION,
    source="Newmark (1965); D = A g t_0² (A/N - 1)/2 for a rectangular pulse",
    reference="formula",
    ours="pulse, sines and yield acceleration",
    measure=measure_newmark,
    draw=draw_newmark,
    quantities={
        "pulse": Quantity(Kind.DISPLACEMENT, 1.0e-6, 1.0e-6, "the integration is exact but for the pulse's sides of 1e-9 s"),
        "sine_train": Quantity(Kind.DISPLACEMENT, 1.0e-4, 1.0e-4, "exact but for the sampling of the sine at 1 ms"),
    },
)
V13 = Case(
    title="Simple shear of one element",
    scene="config/scenes/validation/v13_simple_shear.yaml",
    source=(
        "closed form; τ_f + (τ - τ_f) exp(-γ (t - t_f)) with τ that of the solid state, τ_s where it yields, and no stress from rotation"
    ),
    ours="element, rate of shear and soil",
    measure=measure_simple_shear,
    draw=draw_simple_shear,
    size="numerics.time_step",
    runs={
        "shear": {},
        "elastic": {"coupling": {"solid_after_failure": "elastic"}},
        "spin": {"prescribed_velocity_gradient": {"xy": -1.0, "yx": 1.0}},
    },
    levels=at_time_steps({"1e-3 s": 1.0e-3, "5e-4 s": 5.0e-4, "2.5e-4 s": 2.5e-4}),
    quantities={
        "peak_strength": Quantity(Kind.STRENGTH, 1.0e-3, 1.0e-3, "closed form; the return to the surface is exact"),
        "strength_after": Quantity(Kind.STRENGTH, 0.01, 0.02, "closed form; t_f is known to a time step"),
        "elastic_after": Quantity(
            Kind.STRENGTH,
            0.01,
            0.02,
            "closed form of the paper's solid state, elastic after failure: τ = τ_s + G times the strain since t_f",
        ),
        "spin_deviator": Quantity(Kind.STRESS, 1.0e-6, 1.0e-6, "closed form; deviator after 0.6 rad over the shear modulus"),
        "spin_pressure": Quantity(Kind.STRESS, 1.0e-3, 1.0e-3, "closed form; change of pressure after 0.6 rad over the bulk modulus"),
    },
)
V14 = Case(
    title="Mohr-Coulomb return",
    scene="config/scenes/paper.yaml",
    by=COMPUTATION,
    source="definition of the surface",
    ours="random stresses and soil",
    measure=measure_return,
    draw=draw_return,
    quantities={
        "overshoot": Quantity(Kind.STRESS, 1.0e-10, 1.0e-10, "rounding; over the strength"),
        "turn": Quantity(Kind.STRESS, 1.0e-10, 1.0e-10, "rounding; radians"),
        "apex": Quantity(Kind.STRESS, 1.0e-10, 1.0e-10, "rounding; over the apex' tension"),
    },
)
