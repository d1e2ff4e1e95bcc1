"""Implausible properties of soil, seams and walls, and soil that gravity alone brings to its strength, found before a run.

Implausible properties are mostly due to a mistaken unit.  They are warnings and no refusals: a trial with divided strength, a draw of
uncertain soil or an undrained test of clay may have them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sph.checks.finding import Finding, Severity, finding, off_by
from sph.scene.geometry import SLOPES, Slope
from sph.scene.gravity import FAILED_AREA, UniformStress
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.scene.uncertain import STEEPEST
from sph.solver.initial_stress import effective_overburden
from sph.solver.particles import Particles, peak_strength

DENSITIES = 1000.0, 3000.0
"""Usual densities of soil and rock, kg/m3: from loose or organic soil to dense rock."""
WAVE_SPEEDS = 30.0, 3500.0
"""Usual speeds of shear waves, m/s: from mud to sound rock."""
COHESIONS = 0.1, 1000.0
"""Cohesions, kPa, below which it is none or a number in MPa, and above which it is that of sound rock or a number in Pa."""
LARGEST_TANGENT = math.tan(math.radians(STEEPEST))
"""Tangent of the largest friction angle of a scene, which is larger than the angle in radians: what is above 0 and below it may be either
of them and no angle in degrees, and a coefficient of friction above it an angle."""
SMALLEST_ANGLE, SMALLEST_COHESION = 5.0, 5.0
"""Friction angle (degree) and cohesion (kPa) below both of which hardly any slope stands."""
USED_UP = 0.95
"""Share of its peak strength from which on hardly any is left to the shaking."""


def mobilised_strength(name: str, share: float, when: str, where: str = "", wanted: str = "", key: str = "") -> Finding:
    """The finding of a share of its peak strength that a layer mobilises under gravity alone; a warning where hardly any is left."""
    near = share >= USED_UP
    path = "soil" if name == "soil" else f"layers.{name}.soil"
    return finding(
        "mobilised-strength",
        f"strength of {name} mobilised by gravity alone, {when}",
        f"{100 * share:.0f} % of its peak strength{where}",
        f"less than {100 * USED_UP:.0f} %, {wanted or 'or be computed from a known initial stress'}" if near else "",
        f"{path}.K0, or {key or 'its strength'}" if near else "",
        Severity.WARNING if near else None,
        subject=name,
        off_by=off_by(share, USED_UP) if near else 1.0,
    )


def at_rest(scene: Scene, particles: Particles) -> np.ndarray:
    """Share (n_soil,) of its peak strength that the soil mobilises where it lies as in level ground at the same depth.

    Of the effective stresses sigma_v and K0 sigma_v (Rankine 1857), in plane strain:

        |1 - K0| / 2 sigma_v / (c cos(phi) + (1 + K0) / 2 sigma_v sin(phi)),

    1 at the active and at the passive limit; beyond 1 the soil yields while gravity is brought on.
    """
    soil = slice(0, particles.n_soil)
    vertical = effective_overburden(scene, particles.x[soil], particles.y[soil])
    ratio = np.array([each.at_rest for each in scene.soils])[particles.layer[soil]]
    cohesion, angle = peak_strength(scene, particles)[:, soil]
    radius, at_yield = 0.5 * np.abs(1.0 - ratio) * vertical, cohesion * np.cos(angle) + 0.5 * (1.0 + ratio) * vertical * np.sin(angle)
    return np.divide(radius, at_yield, out=np.zeros_like(radius), where=at_yield > 0.0)


def of_rest(scene: Scene, particles: Particles) -> list[Finding]:
    """A warning for each layer of which more than ``FAILED_AREA`` H^2 has hardly any strength left in level ground at rest, by ``at_rest``.

    Not on an incline, nor where the soil starts with a uniform pressure, as debris, or without weight; nor of shapes without a slope.
    """
    gravity, geometry = scene.gravity, scene.geometry
    level = gravity.inclination == 0.0 and gravity.acceleration > 0.0 and not isinstance(gravity.initial_stress, UniformStress)
    free = scene.coupling.initial_state == "solid" and scene.prescribed_velocity_gradient is None
    if not (level and free and isinstance(geometry, SLOPES)):
        return []
    soil, found = slice(0, particles.n_soil), []
    shares, depth = at_rest(scene, particles), geometry.ground(particles.x[soil]) - particles.y[soil]
    for number, (name, its) in enumerate(zip(("soil", *scene.layers), scene.soils, strict=True)):
        near = (particles.layer[soil] == number) & (shares >= USED_UP)
        if np.count_nonzero(near) * scene.numerics.spacing**2 > FAILED_AREA * (geometry.crest[1] - geometry.toe[1]) ** 2:
            worst = int(np.argmax(np.where(near, shares, 0.0)))
            given, held = f"{its.at_rest:.3g}{' = nu / (1 - nu)' if its.K0 is None else ''}", _held_at_rest(scene, particles, worst)
            where = f" at a depth of {depth[worst]:.3g} m with K0 = {given}"
            where += f", {100 * USED_UP:.0f} % or more from {depth[near].min():.3g} m downwards"
            bound = f"at least {held:.3g} (nu {held / (1 + held):.3g})" if held < 1.0 else f"at most {held:.3g}"
            when, key = "in level ground at rest (Rankine)", "poisson_ratio" if its.K0 is None else ""
            found.append(mobilised_strength(name, float(shares[worst]), when, where, f"as with a K0 of {bound}", key))
    return found


def _held_at_rest(scene: Scene, particles: Particles, i: int) -> float:
    """The K0 nearest to a particle's own with which it mobilises ``USED_UP`` of its strength."""
    vertical = float(effective_overburden(scene, particles.x[i : i + 1], particles.y[i : i + 1])[0])
    cohesion, angle = peak_strength(scene, particles)[:, i]
    part = USED_UP * np.array([np.sin(angle), 2.0 * cohesion * np.cos(angle) / vertical])
    active = scene.soils[particles.layer[i]].at_rest < 1.0
    return float((1.0 - part[0] - part[1]) / (1.0 + part[0]) if active else (1.0 + part[0] + part[1]) / (1.0 - part[0]))


def of_soils(scene: Scene) -> list[Finding]:
    """Warnings of the soil, each layer, each seam and the walls of the user's own slope; a layer is not told what it takes over.

    The paper's scheme takes its soil from the paper.
    """
    if scene.scheme == "paper" or not isinstance(scene.geometry, SLOPES):
        return []
    own = _of_soil("soil", "soil", scene.soil)
    layers = [each for name, layer in scene.layers.items() for each in _of_soil(name, f"layers.{name}.soil", layer.soil)]
    taken_over = {(each.code, each.off_by) for each in own}
    others = [
        each
        for name, seam in scene.seams.items()
        for each in _of_strength(f"seam {name}", f"seams.{name}", {key: value for key, value in seam if isinstance(value, float)})
    ]
    for side in ("base", "sides"):
        friction = getattr(scene.walls.friction, side, 0.0)
        if friction > LARGEST_TANGENT:
            key = f"walls.friction.{side}"
            wanted = f"a tangent, at most {LARGEST_TANGENT:.2g}; that of {friction:g} degrees is {math.tan(math.radians(friction)):.3g}"
            others.append(
                _told("angle-implausible", f"the friction of the walls ({side})", key, f"{friction:g}", wanted, friction, LARGEST_TANGENT)
            )
    if isinstance(scene.geometry, Slope) and scene.geometry.slope_angle < math.pi / 2:
        others.append(_of_angle("the slope", "geometry.slope_angle", scene.geometry.slope_angle, math.pi / 2))
    return [*own, *(each for each in layers if (each.code, each.off_by) not in taken_over), *others]


def _told(code: str, what: str, key: str, measured: str, wanted: str, value: float, bound: float, name: str = "") -> Finding:
    return finding(code, f"{what} is implausible", f"{key} {measured}", wanted, key, subject=name, off_by=off_by(value, bound))


def _of_angle(name: str, key: str, angle: float, least: float) -> Finding:
    """Of an angle (degree) that may be in radians, or a tangent."""
    what = f"the {key.rsplit('.', 1)[-1].replace('_', ' ')} of {name}"
    wanted = f"at least {least:.2g} degree, or 0; {angle:g} rad are {math.degrees(angle):.3g} degree, and {angle:g} is the tangent of "
    wanted += f"{math.degrees(math.atan(angle)):.3g} degree"
    return _told("angle-implausible", what, key, f"{angle:g} degree", wanted, angle, least, name)


def _of_strength(name: str, path: str, values: Mapping[str, float]) -> list[Finding]:
    """Of the angles (degree) and cohesions (kPa) of soil or a seam that lies at a dotted key."""
    found = []
    for each, value in values.items():
        key = f"{path}.{each}"
        if each.endswith("_angle") and 0.0 < value < LARGEST_TANGENT:
            found.append(_of_angle(name, key, value, LARGEST_TANGENT))
        elif each.endswith("cohesion") and value and not COHESIONS[0] <= value <= COHESIONS[1]:
            small = value < COHESIONS[0]
            wanted = f"at least {COHESIONS[0]:g} kPa, or 0; 20 kPa are 0.02 MPa" if small else "at most 1,000 kPa; 20 kPa are 20000 Pa"
            what = f"the {each.replace('_', ' ')} of {name}"
            found.append(_told("cohesion-implausible", what, key, f"{value:g} kPa", wanted, value, COHESIONS[0 if small else 1], name))
    return found


def _of_soil(name: str, path: str, soil: Soil) -> list[Finding]:
    """Of the soil that lies at a dotted key."""
    found = []
    if not DENSITIES[0] <= soil.density <= DENSITIES[1]:
        bound = min(DENSITIES, key=lambda bound: abs(bound - soil.density))
        measured = f"{soil.density:g} kg/m3"
        what, wanted = f"the density of {name}", "1,000 to 3,000 kg/m3"
        found.append(_told("density-implausible", what, f"{path}.density", measured, wanted, soil.density, bound, name))
    speed = soil.s_wave_speed
    if not WAVE_SPEEDS[0] <= speed <= WAVE_SPEEDS[1]:
        bound = min(WAVE_SPEEDS, key=lambda bound: abs(bound - speed))
        measured = f"{soil.youngs_modulus:g} kPa, V_s = {speed:.3g} m/s"
        what, wanted = f"the stiffness of {name}", "V_s = 30 to 3,500 m/s"
        found.append(_told("stiffness-implausible", what, f"{path}.youngs_modulus", measured, wanted, speed, bound, name))
    strengths = {key: value for key, value in soil if isinstance(value, float)}
    if soil.gradient and soil.cohesion < COHESIONS[0]:
        strengths.pop("cohesion")  # at the top, below which it grows
    found += _of_strength(name, path, strengths)
    if soil.friction_angle < SMALLEST_ANGLE and soil.cohesion < SMALLEST_COHESION and not soil.gradient:
        cohesion = f"{path}.cohesion"
        what = f"the peak strength of {name} is implausibly low"
        measured = f"{cohesion} {soil.cohesion:g} kPa and {path}.friction_angle {soil.friction_angle:g} degree"
        wanted = f"at least {SMALLEST_COHESION:g} kPa or at least {SMALLEST_ANGLE:g} degree"
        off = min(off_by(soil.cohesion, SMALLEST_COHESION), off_by(soil.friction_angle, SMALLEST_ANGLE))
        found.append(finding("strength-implausible", what, measured, wanted, cohesion, subject=name, off_by=off))
    return found
