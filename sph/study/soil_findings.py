"""Implausible soil properties, mostly due to a mistaken unit, found before a run."""

from __future__ import annotations

from sph.scene.geometry import SLOPES
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.study.finding import Finding, finding, off_by

DENSITIES = 1000.0, 3000.0
"""Usual densities of soil and rock, kg/m3: from loose or organic soil to dense rock."""
WAVE_SPEEDS = 30.0, 3500.0
"""Usual speeds of shear waves, m/s: from mud to sound rock."""
LARGEST_COHESION = 1000.0
"""Cohesion above which it is that of sound rock, or a number in Pa, kPa."""
SMALLEST_ANGLE, SMALLEST_COHESION = 5.0, 5.0
"""Friction angle (degree) and cohesion (kPa) below both of which hardly any slope stands."""


def of_soils(scene: Scene) -> list[Finding]:
    """Warnings of the peak properties of the soil and of each layer of the user's own slope; a layer is not told what it takes over.

    The paper's scheme takes its soil from the paper.  Residual strengths may be as small as they are measured.
    """
    if scene.scheme == "paper" or not isinstance(scene.geometry, SLOPES):
        return []
    own = _of_soil("soil", "soil", scene.soil)
    layers = [each for name, layer in scene.layers.items() for each in _of_soil(name, f"layers.{name}.soil", layer.soil)]
    taken_over = {(each.code, each.off_by) for each in own}
    return [*own, *(each for each in layers if (each.code, each.off_by) not in taken_over)]


def _of_soil(name: str, path: str, soil: Soil) -> list[Finding]:
    """Of the soil that lies at a dotted key."""
    cohesion, angle = f"{path}.cohesion", f"{path}.friction_angle"
    found = []

    def tell(code: str, what: str, key: str, measured: str, wanted: str, off: float) -> None:
        found.append(finding(code, what, f"{key} {measured}", wanted, key, subject=name, off_by=off))

    if not DENSITIES[0] <= soil.density <= DENSITIES[1]:
        wanted = "1,000 to 3,000 kg/m3"
        off = off_by(soil.density, min(DENSITIES, key=lambda bound: abs(bound - soil.density)))
        tell("density-implausible", f"the density of {name} is implausible", f"{path}.density", f"{soil.density:g} kg/m3", wanted, off)
    speed = soil.s_wave_speed
    if not WAVE_SPEEDS[0] <= speed <= WAVE_SPEEDS[1]:
        what = f"the stiffness of {name} is implausible"
        measured = f"{soil.youngs_modulus:g} kPa, V_s = {speed:.3g} m/s"
        off = off_by(speed, min(WAVE_SPEEDS, key=lambda bound: abs(bound - speed)))
        tell("stiffness-implausible", what, f"{path}.youngs_modulus", measured, "V_s = 30 to 3,500 m/s", off)
    if soil.cohesion > LARGEST_COHESION:
        off = off_by(soil.cohesion, LARGEST_COHESION)
        what = f"the cohesion of {name} is implausible"
        tell("cohesion-implausible", what, cohesion, f"{soil.cohesion:g} kPa", "at most 1,000 kPa; 20 kPa are 20000 Pa", off)
    if soil.friction_angle < SMALLEST_ANGLE and soil.cohesion < SMALLEST_COHESION and not soil.gradient:
        measured = f"{soil.cohesion:g} kPa and {angle} {soil.friction_angle:g} degree"
        wanted = f"at least {SMALLEST_COHESION:g} kPa or at least {SMALLEST_ANGLE:g} degree"
        off = min(off_by(soil.cohesion, SMALLEST_COHESION), off_by(soil.friction_angle, SMALLEST_ANGLE))
        tell("strength-implausible", f"the peak strength of {name} is implausibly low", cohesion, measured, wanted, off)
    return found
