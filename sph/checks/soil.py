"""Implausible properties of soil, seams and walls, and soil that gravity alone brings to its strength, found before a run.

Implausible properties are mostly due to a mistaken unit.  They are warnings and no refusals: a trial with divided strength, a draw of
uncertain soil or an undrained test of clay may have them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sph.checks.finding import Finding, finding
from sph.scene.geometry import SLOPES, Slope
from sph.scene.gravity import FAILED_AREA, UniformStress
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.scene.uncertain import STEEPEST
from sph.solver.particles import Particles, peak_strength
from sph.solver.physics.pore_pressure import effective_overburden

DENSITIES = 1000.0, 3000.0
"""Usual densities of soil and rock, kg/m3: from loose or organic soil to dense rock."""
WAVE_SPEEDS = 30.0, 3500.0
"""Usual speeds of shear waves, m/s: from mud to sound rock."""
COHESIONS = 0.1, 1000.0
"""Cohesions, kPa, below which it is none or a number in MPa, and above which it is that of sound rock or a number in Pa."""
MAX_TANGENT = math.tan(math.radians(STEEPEST))
"""Tangent of the largest friction angle of a scene, which is larger than the angle in radians: what is above 0 and below it may be either
of them and no angle in degrees, and a coefficient of friction above it an angle."""
MIN_ANGLE, MIN_COHESION = 5.0, 5.0
"""Friction angle (degree) and cohesion (kPa) below both of which hardly any slope stands."""
USED_UP = 0.95
"""Share of its peak strength from which on hardly any is left to the shaking."""


def mobilised_strength(name: str, share: float, *keys: str, **numbers: float | None) -> Finding:
    """The finding of a share of its peak strength that a layer mobilises under gravity alone; bounded where hardly any is left.

    ``keys`` of the soil may change that, beside its K0.
    """
    path = "soil" if name == "soil" else f"layers.{name}.soil"
    if share < USED_UP:
        return finding("mobilised-strength", subject=name, value=share, **numbers)
    others = keys or ("cohesion", "friction_angle")
    changed = (f"{path}.{key}" for key in ("K0", *others))
    return finding("mobilised-strength", *changed, subject=name, value=share, bound=USED_UP, **numbers)


def at_rest(scene: Scene, particles: Particles) -> np.ndarray:
    """Share (n_soil,) of its peak strength that the soil mobilises where it lies as in level ground at the same depth.

    Of the effective stresses sigma_v and K0 sigma_v (Rankine 1857), in plane strain:

        |1 - K0| / 2 sigma_v / (c cos(phi) + (1 + K0) / 2 sigma_v sin(phi)),

    1 at the active and at the passive limit; beyond 1 the soil yields while gravity is brought on.  A strength below 1 Pa counts as 1 Pa.
    """
    soil = slice(0, particles.n_soil)
    vertical = effective_overburden(scene, particles.x[soil], particles.y[soil])
    ratio = np.array([each.at_rest for each in scene.soils])[particles.layer[soil]]
    cohesion, angle = peak_strength(scene, particles)[:, soil]
    radius, at_yield = 0.5 * np.abs(1.0 - ratio) * vertical, cohesion * np.cos(angle) + 0.5 * (1.0 + ratio) * vertical * np.sin(angle)
    return np.divide(radius, np.maximum(at_yield, 1.0), out=np.zeros_like(radius), where=at_yield > 0.0)


def of_rest(scene: Scene, particles: Particles) -> list[Finding]:
    """A warning for each layer of which more than ``FAILED_AREA`` H^2 has hardly any strength left in level ground at rest, by ``at_rest``.

    Not on an incline, nor where the soil starts with a uniform pressure, as debris, or without weight; nor of shapes without a slope.
    """
    gravity, geometry = scene.gravity, scene.geometry
    level = gravity.inclination == 0.0 and gravity.acceleration > 0.0 and not isinstance(gravity.initial_stress, UniformStress)
    free = scene.coupling.initial_state == "solid" and scene.prescribed_velocity_gradient is None
    if not (level and free and isinstance(geometry, SLOPES)):
        return []
    soil, findings = slice(0, particles.n_soil), []
    shares, depth = at_rest(scene, particles), geometry.ground(particles.x[soil]) - particles.y[soil]
    for number, (name, its) in enumerate(zip(("soil", *scene.layers), scene.soils, strict=True)):
        near = (particles.layer[soil] == number) & (shares >= USED_UP)
        if np.count_nonzero(near) * scene.numerics.spacing**2 > FAILED_AREA * (geometry.crest[1] - geometry.toe[1]) ** 2:
            worst = int(np.argmax(np.where(near, shares, 0.0)))
            numbers = {"depth": depth[worst], "from_depth": depth[near].min(), "K0": its.at_rest}
            ratio = its.poisson_ratio if its.K0 is None else None
            keys = () if ratio is None else ("poisson_ratio",)
            held = _held_at_rest(scene, particles, worst)
            findings.append(mobilised_strength(name, float(shares[worst]), *keys, **numbers, poisson_ratio=ratio, held_K0=held))
    return findings


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
        if friction > MAX_TANGENT:
            others.append(finding("angle-implausible", f"walls.friction.{side}", subject=side, value=friction, bound=MAX_TANGENT))
    if isinstance(scene.geometry, Slope) and scene.geometry.slope_angle < math.pi / 2:
        others.append(_of_angle("the slope", "geometry.slope_angle", scene.geometry.slope_angle, math.pi / 2))
    others += [each for name, layer in scene.layers.items() for each in _of_residual(name, layer.soil, scene.soil)]
    return [*own, *(each for each in layers if (each.code, each.off_by) not in taken_over), *others]


def _of_residual(name: str, soil: Soil, main: Soil) -> list[Finding]:
    """Of a layer that is stronger than the main soil at its peak and falls to the same residual strength, as if it took that over."""
    cohesion, angle = soil.residual_cohesion, soil.residual_friction_angle
    if cohesion is None or angle is None or (cohesion, angle) != (main.residual_cohesion, main.residual_friction_angle):
        return []
    peak, mains = (soil.cohesion, soil.friction_angle), (main.cohesion, main.friction_angle)
    if peak == mains or peak[0] < mains[0] or peak[1] < mains[1]:
        return []
    keys = (f"layers.{name}.soil.residual_{key}" for key in ("cohesion", "friction_angle"))
    return [finding("residual-taken-over", *keys, subject=name, cohesion=1e3 * cohesion, friction_angle=math.radians(angle))]


def _of_angle(name: str, key: str, angle: float, least: float) -> Finding:
    """Of an angle (degree) that may be in radians, or a tangent."""
    return finding("angle-implausible", key, subject=name, value=math.radians(angle), bound=math.radians(least))


def _of_strength(name: str, path: str, values: Mapping[str, float]) -> list[Finding]:
    """Of the angles (degree) and cohesions (kPa) of soil or a seam that lies at a dotted key."""
    findings = []
    for each, value in values.items():
        key = f"{path}.{each}"
        if each.endswith("_angle") and 0.0 < value <= MAX_TANGENT:
            findings.append(_of_angle(name, key, value, MAX_TANGENT))
        elif each.endswith("cohesion") and value and not COHESIONS[0] <= value <= COHESIONS[1]:
            bound = COHESIONS[0 if value < COHESIONS[0] else 1]
            findings.append(finding("cohesion-implausible", key, subject=name, value=1e3 * value, bound=1e3 * bound))
    return findings


def _beyond(code: str, key: str, name: str, value: float, usual: tuple[float, float], **numbers: float) -> list[Finding]:
    """The finding of a value outside its usual range, beside the nearer end."""
    least, most = usual
    if least <= value <= most:
        return []
    bound = least if value < least else most
    return [finding(code, key, subject=name, value=value, bound=bound, least=least, most=most, **numbers)]


def _of_soil(name: str, path: str, soil: Soil) -> list[Finding]:
    """Of the soil that lies at a dotted key."""
    findings = _beyond("density-implausible", f"{path}.density", name, soil.density, DENSITIES)
    stiffness = {"youngs_modulus": 1e3 * soil.youngs_modulus}
    findings += _beyond("stiffness-implausible", f"{path}.youngs_modulus", name, soil.s_wave_speed, WAVE_SPEEDS, **stiffness)
    strengths = {key: value for key, value in soil if isinstance(value, float)}
    if soil.gradient and soil.cohesion < COHESIONS[0]:
        strengths.pop("cohesion")  # at the top, below which it grows
    findings += _of_strength(name, path, strengths)
    if soil.friction_angle < MIN_ANGLE and soil.cohesion < MIN_COHESION and not soil.gradient:
        strength = {"cohesion": soil.cohesion_si, "friction_angle": soil.friction_angle_si}
        least = {"least_cohesion": 1e3 * MIN_COHESION, "least_angle": math.radians(MIN_ANGLE)}
        nearer = max(soil.cohesion / MIN_COHESION, soil.friction_angle / MIN_ANGLE)
        findings.append(finding("strength-implausible", f"{path}.cohesion", subject=name, value=nearer, bound=1.0, **strength, **least))
    return findings
