"""A block on a seam: constant push, Newmark's block and loss of strength, at several dips and spacings; factors of safety."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from small_scenes import NOTHING

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.run import run
from sph.stability.safety import DEFAULT_RULE
from sph.stability.slip_search import limit_equilibrium
from sph.stability.standing import divided_strength, stand, static_scene

LENGTH, HEIGHT, DENSITY, GRAVITY = 24.0, 8.0, 2000.0, 9.81
"""Of the block, m, kg/m3 and m/s2."""
WIDTH, BASE, START = 44.0, 6.0, 12.0
"""Of the box, height of the seam at its left side, and distance of the block from there along x, m."""
SHAKEN_FROM = 2.0
"""s"""
SLOPES = {"aligned": (0.0, 12.0), "12 degrees": (12.0, 0.0), "25 degrees": (25.0, 0.0)}
"""Dip of the seam over the lattice, and angle by which gravity is turned besides, degrees."""
SEAMS = {"aligned": (20.0, 15.0), "12 degrees": (20.0, 15.0), "25 degrees": (20.0, 28.0)}
"""Cohesion (kPa) and friction angle (degrees)."""
FINER = [*((slope, 0.5) for slope in SLOPES), ("25 degrees", 0.25)]
DIPS_AND_SPACINGS = pytest.mark.parametrize(
    ("slope", "spacing"), [*((slope, 1.0) for slope in SLOPES), *(pytest.param(*each, marks=pytest.mark.long) for each in FINER)]
)
DIPS = pytest.mark.parametrize("slope", [name if name == "aligned" else pytest.param(name, marks=pytest.mark.long) for name in SLOPES])


def block_scene(
    slope: str,
    spacing: float,
    motion: dict[str, Any],
    seam: dict[str, Any] | None = None,
    lasts: float = 2.0,
    modulus: float = 2e5,
    damping: dict[str, Any] | None = None,
) -> Scene:
    """A block of strong soil on strong ground, on a seam that dips to the left through the corner (0, BASE)."""
    dip, turned = SLOPES[slope]
    rise, along = math.tan(math.radians(dip)), np.array([math.cos(math.radians(dip)), math.sin(math.radians(dip))])
    foot, up = np.array([START, BASE + START * rise]), np.array([-along[1], along[0]])
    corners = [foot, foot + LENGTH * along, foot + LENGTH * along + HEIGHT * up, foot + HEIGHT * up]
    ground = [[0.0, 0.0], [WIDTH, 0.0], [WIDTH, BASE + WIDTH * rise], [0.0, BASE]]
    cohesion, angle = SEAMS[slope]
    return make_scene(
        {
            "name": "block",
            "duration": SHAKEN_FROM + lasts,
            "geometry": {
                "shape": "bodies",
                "width": WIDTH,
                "height": math.ceil(max(y for _, y in [*ground, *corners])) + 1.0,
                "bodies": [{"kind": "polygon", "points": part} for part in (ground, [corner.tolist() for corner in corners])],
            },
            "walls": {"base": "no_slip", "sides": "free_slip"},
            "soil": {
                "density": DENSITY,
                "youngs_modulus": modulus,
                "poisson_ratio": 0.3,
                "cohesion": 2000.0,
                "friction_angle": 30.0,
                "viscosity": 2.0,
            },
            "seams": {
                "seam": {
                    "points": [[-5.0, BASE - 5.0 * rise], [60.0, BASE + 60.0 * rise]],
                    "cohesion": cohesion,
                    "friction_angle": angle,
                    **(seam or {}),
                }
            },
            "coupling": {"S_R": 1.0, "gamma": 0.0},
            # Of stiffness alone, against hum.
            "damping": damping or {"ratio": 0.1 if modulus == 2e5 else 0.5, "frequencies": [0.001, 50.0]},
            "gravity": {"ramp": 0.5, "duration": SHAKEN_FROM, "acceleration": GRAVITY, "inclination": turned},
            "motion": {"start": SHAKEN_FROM, **motion},
            "numerics": {"spacing": spacing},
            "probes": {"A": (foot + 0.5 * LENGTH * along + 0.5 * HEIGHT * up).tolist()},
            "outputs": {"frame_interval": 0.5, "series_interval": 0.01},
        }
    )


class Slide(NamedTuple):
    """Motion of the block down the seam from the start of the shaking: time (s), displacement (m), speed (m/s), push (m/s2)."""

    time: np.ndarray
    moved: np.ndarray
    speed: np.ndarray
    ground: np.ndarray


def slide(scene: Scene, slope: str) -> Slide:
    data = run(scene).trajectory
    dip = math.radians(SLOPES[slope][0])
    since = data["sample_time"].values >= SHAKEN_FROM - 1e-9
    moved, speed = (
        -math.cos(dip) * data[f"probe_{what}_x"].values[since, 0] - math.sin(dip) * data[f"probe_{what}_y"].values[since, 0]
        for what in ("displacement", "velocity")
    )
    return Slide(data["sample_time"].values[since] - SHAKEN_FROM, moved - moved[0], speed, data["ground_acceleration"].values[since])


def acceleration(slope: str, push: float, cohesion: float, friction: float) -> float:
    """Of a block that slides down, under a ground acceleration (m/s2) of the box, m/s2; cohesion in Pa and tan(phi)."""
    dip, turned = (math.radians(angle) for angle in SLOPES[slope])
    normal = GRAVITY * math.cos(dip + turned) - push * math.sin(dip)
    return GRAVITY * math.sin(dip + turned) + push * math.cos(dip) - normal * friction - cohesion / (DENSITY * HEIGHT)


def strength(slope: str) -> tuple[float, float]:
    """Cohesion (Pa) and tan(phi)."""
    cohesion, angle = SEAMS[slope]
    return 1e3 * cohesion, math.tan(math.radians(angle))


@DIPS_AND_SPACINGS
def test_a_block_slides_down_a_seam_as_its_strength_has_it(slope: str, spacing: float) -> None:
    """s = s_0 + v_0 t + a t^2 / 2 from where it has slipped by 0.1 m, with the speed that it has there; within 3 %."""
    found = slide(block_scene(slope, spacing, {"kind": "constant", "amplitude": 4.0, "ramp": 0.3}), slope)
    expected, start = acceleration(slope, 4.0, *strength(slope)), int(np.argmax((found.moved > 0.1) & (found.time > 0.3)))
    for wanted in (0.5, 1.0, 2.0, 3.0):
        at = int(np.argmax(found.moved > wanted))
        lasted = found.time[at] - found.time[start]
        moved = found.moved[start] + found.speed[start] * lasted + 0.5 * expected * lasted**2
        print(f"{slope}, {spacing:g} m: {found.moved[at]:.3f} m for {moved:.3f} m, {found.moved[at] / moved - 1.0:+.1%}")
        assert found.moved[at] == pytest.approx(moved, rel=0.03)


WEAKENING = {"slip_at_peak": 0.05, "slip_at_residual": 0.8, "residual_cohesion": 5.0, "residual_friction_angle": 8.0}


@DIPS_AND_SPACINGS
def test_a_block_on_a_seam_that_weakens(slope: str, spacing: float) -> None:
    """s'' with c and tan(phi) that fall with the displacement across the seam, likewise; within 3 %."""
    peak, friction = strength(slope)
    residual, residual_friction = 1e3 * WEAKENING["residual_cohesion"], math.tan(math.radians(WEAKENING["residual_friction_angle"]))
    found = slide(block_scene(slope, spacing, {"kind": "constant", "amplitude": 4.0, "ramp": 0.3}, WEAKENING, 1.6), slope)
    start = int(np.argmax((found.moved > 0.1) & (found.time > 0.3)))

    def push(_: float, state: np.ndarray) -> tuple[float, float]:
        lost = min(max((state[0] - WEAKENING["slip_at_peak"]) / (WEAKENING["slip_at_residual"] - WEAKENING["slip_at_peak"]), 0.0), 1.0)
        c, mu = peak + lost * (residual - peak), friction + lost * (residual_friction - friction)
        return state[1], acceleration(slope, 4.0, c, mu)

    block = solve_ivp(push, (0.0, 3.0), (found.moved[start], found.speed[start]), rtol=1e-8, max_step=0.01, dense_output=True).sol
    for wanted in (0.3, 0.6, 1.0, 2.0):
        at = int(np.argmax(found.moved > wanted))
        moved = block(found.time[at] - found.time[start])[0]
        print(f"{slope}, {spacing:g} m: {found.moved[at]:.3f} m for {moved:.3f} m, {found.moved[at] / moved - 1.0:+.1%}")
        assert found.moved[at] == pytest.approx(moved, rel=0.03)


def newmark(slope: str, spacing: float, cohesion: float) -> tuple[float, dict[float, float]]:
    """Displacement (m) under two waves that drive the block down in steps, and those of rigid blocks by a factor of the seam's strength.

    The soil is stiff and damped, so that the block is rigid.  With another ``cohesion`` (kPa) friction makes up for it under gravity.
    """
    end, (usual, friction) = SHAKEN_FROM + 5.0, strength(slope)
    pressure = DENSITY * HEIGHT * GRAVITY * math.cos(math.radians(sum(SLOPES[slope])))
    friction += (usual - 1e3 * cohesion) / pressure
    motion = {"kind": "tapered_sine", "amplitude": 5.0, "frequency": 0.4, "ramp": 0.5, "decay_start": end, "end": end}
    seam = {"cohesion": cohesion, "friction_angle": math.degrees(math.atan(friction))}
    found = slide(block_scene(slope, spacing, motion, seam, lasts=6.0, modulus=4e6), slope)
    step, moved = 1e-3, {}
    for factor in (1.03, 1.0, 0.97):
        displacement = speed = 0.0
        for time in np.arange(0.0, 6.0, step):
            pushed = acceleration(slope, float(np.interp(time, found.time, found.ground)), factor * 1e3 * cohesion, factor * friction)
            speed = max(speed + pushed * step, 0.0)
            displacement += speed * step
        moved[factor] = displacement
    print(f"{slope}, {spacing:g} m: {found.moved[-1]:.3f} m for {moved[1.0]:.3f} m, {found.moved[-1] / moved[1.0] - 1.0:+.1%}; {moved}")
    return float(found.moved[-1]), moved


@pytest.mark.long
@DIPS
def test_newmarks_block(slope: str) -> None:
    """As far as a rigid block whose strength is within 3 % of the seam's; Newmark's displacement magnifies an error of the strength."""
    found, rigid = newmark(slope, 1.0, SEAMS[slope][0])
    assert rigid[1.03] < found < rigid[0.97]


@pytest.mark.long
@pytest.mark.parametrize("spacing", [1.0, 2 / 3])
def test_newmarks_block_with_friction_alone(spacing: float) -> None:
    """Friction follows the sum of the normal forces, cohesion does not: the displacement itself within 3 % at 1 m.

    It is at 0.5 m too; at 0.67 m it is 6 % too large, as that of a block with 2 % less strength.
    """
    found, rigid = newmark("25 degrees", spacing, 0.0)
    assert rigid[1.03] < found < rigid[0.97]
    assert spacing < 1.0 or found == pytest.approx(rigid[1.0], rel=0.03)


DAMPED, OF_STIFFNESS_ALONE = {"ratio": 0.03, "frequencies": [1.5, 7.5]}, {"ratio": 0.03, "frequencies": [0.001, 9.0]}
"""Rayleigh damping with and without the part that is proportional to the mass, alpha = 0.47 1/s."""
PUSHES = {
    "constant": ({"kind": "constant", "amplitude": 2.8, "ramp": 0.3}, 4.0),
    "sine": ({"kind": "tapered_sine", "amplitude": 5.0, "frequency": 0.4, "ramp": 0.5, "decay_start": 7.0, "end": 7.0}, 6.0),
}
"""Motions and how long they last, s."""


def damped(slope: str, push: str, damping: dict[str, Any], modulus: float) -> tuple[Slide, float]:
    """Motion of the block, and the displacement (m) of a rigid one on a seam of the same strength."""
    motion, lasts = PUSHES[push]
    found = slide(block_scene(slope, 1.0, motion, lasts=lasts, modulus=modulus, damping=damping), slope)
    step, moved, speed = 1e-3, 0.0, 0.0
    for ground in np.interp(np.arange(0.0, lasts, step), found.time, found.ground):
        speed = max(speed + acceleration(slope, float(ground), *strength(slope)) * step, 0.0)
        moved += speed * step
    return found, moved


@pytest.mark.parametrize("push", ["constant", pytest.param("sine", marks=pytest.mark.long)])
def test_mass_damping_leaves_a_sliding_block_its_displacement(push: str) -> None:
    """s = a t^2 / 2 for 4 s, and Newmark's block under a sine, within 2 %; damped as soil that holds, it would move 39 % too little."""
    found, moved = damped("aligned", push, DAMPED, 2e6)
    print(f"{push}: {found.moved[-1]:.3f} m for {moved:.3f} m, {found.moved[-1] / moved - 1.0:+.1%}")
    assert found.moved[-1] == pytest.approx(moved, rel=0.02)


@pytest.mark.parametrize(("push", "modulus"), [("constant", 2e5), pytest.param("sine", 2e6, marks=pytest.mark.long)])
@DIPS
def test_mass_damping_changes_nothing_about_sliding(slope: str, push: str, modulus: float) -> None:
    """Whatever the lattice: displacement with and without it within 1 % of each other.

    Under the sine the soil is stiff: a soft block that holds swings, which mass damping may damp (2.5 % at 25 degrees and 2e5 kPa).
    """
    (one, _), (other, _) = (damped(slope, push, damping, modulus) for damping in (DAMPED, OF_STIFFNESS_ALONE))
    print(f"{slope}, {push}: {one.moved[-1]:.3f} m, without mass damping {other.moved[-1]:.3f} m")
    assert one.moved[-1] == pytest.approx(other.moved[-1], rel=0.01)


# ---------------------------------------------------------------- factors of safety

UNIT_WEIGHT = DENSITY * GRAVITY / 1e3
"""kN/m3"""
SLOPE: dict[str, Any] = {
    "name": "slope",
    "duration": 10.0,
    "geometry": {"shape": "ground_line", "points": [[-30, 0], [0, 0], [20, 10], [70, 10]], "base": -5.0},
    "walls": {"base": "no_slip", "sides": "free_slip"},
    "soil": {
        "density": DENSITY,
        "youngs_modulus": 1e5,
        "poisson_ratio": 0.3,
        "cohesion": 10.0,
        "friction_angle": 20.0,
        "viscosity": 2.0,
    },
    "coupling": {"S_R": 0.5, "gamma": 0.0},
    "damping": None,
    "gravity": {"acceleration": GRAVITY},
    "numerics": {"spacing": 1.0},
}


def stands(changes: dict[str, Any], spacing: float, factor: float) -> bool:
    scene = static_scene(make_scene(merge(SLOPE, dotted({**changes, "numerics.spacing": spacing}))), DEFAULT_RULE)
    scene = make_scene(scene.model_dump(mode="json") | {"damping": NOTHING["damping"]})  # the variant of the block
    return stand(divided_strength(scene, factor), DEFAULT_RULE, factor).stands


@pytest.mark.parametrize("spacing", [1.0, pytest.param(2 / 3, marks=pytest.mark.long)])
def test_strong_soil_on_a_dipping_seam_has_the_factor_of_a_plane_slide(spacing: float) -> None:
    """F = tan(phi) / tan(dip) + c L / (W sin(dip)) of the wedge from the toe to behind the crest, within 3 %."""
    dip, cohesion, angle = math.radians(12.0), 2.0, 12.0
    length, weight = 10.0 / math.sin(dip), UNIT_WEIGHT * 0.5 * 10.0 * (10.0 / math.tan(dip) - 20.0)
    factor = math.tan(math.radians(angle)) / math.tan(dip) + cohesion * length / (weight * math.sin(dip))
    seam = {"points": [[-5.0, -5.0 * math.tan(dip)], [60.0, 60.0 * math.tan(dip)]], "cohesion": cohesion, "friction_angle": angle}
    changes = {"soil.cohesion": 100.0, "soil.friction_angle": 30.0, "seams": {"clay": seam}}
    assert stands(changes, spacing, 0.97 * factor) and not stands(changes, spacing, 1.03 * factor)


@pytest.mark.long
@pytest.mark.parametrize("spacing", [1.0, 2 / 3])
def test_a_thin_level_seam_under_a_slope(spacing: float) -> None:
    """A seam of 0.4 m at the height of the toe: Spencer's factor within 3 %, where one as strong as the soil leaves the slope its 1.4."""
    seam = {"points": [[-5.0, 0.0], [60.0, 0.0]], "thickness": 0.4, "cohesion": 0.5, "friction_angle": 5.0}
    factor = 0.775
    assert limit_equilibrium(make_scene(merge(SLOPE, {"seams": {"clay": seam}}))).spencer.value == pytest.approx(factor, abs=0.005)
    changes, as_the_soil = {"seams": {"clay": seam}}, {"seams": {"clay": seam | {"cohesion": 10.0, "friction_angle": 20.0}}}
    assert stands(changes, spacing, 0.97 * factor) and not stands(changes, spacing, 1.03 * factor)
    assert stands(as_the_soil, spacing, 1.3)
