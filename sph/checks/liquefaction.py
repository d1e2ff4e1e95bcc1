"""Whether an earthquake of a magnitude liquefies sand or softens clay, by the simplified procedure: before a run, and without one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.checks.finding import Finding, called, finding
from sph.scene.gravity import GRAVITY
from sph.scene.liquefaction import LARGEST_DEPTH, clay_resistance, sand_resistance, stress_reduction
from sph.scene.loading import loading_of
from sph.scene.schema import Scene
from sph.solver.particles import Particles, overburden, peak_strength
from sph.solver.physics.cyclic_pore_pressure import can_liquefy
from sph.solver.physics.pore_pressure import effective_overburden


class Factors(NamedTuple):
    """Factors of safety of a layer's places."""

    layer: str
    is_clay: bool
    depth: np.ndarray  # (n,) m
    safety: np.ndarray  # (n,)


def factors(scene: Scene, particles: Particles, magnitude: float) -> list[Factors]:
    """Those of each layer of sand that can liquefy, and of saturated clay, as on level ground, by its particles.

    The peak of the horizontal motion counts as that of the ground.  A scene without shaking has none.
    """
    soil = slice(0, particles.n_soil)
    x, y, layer = particles.x[soil], particles.y[soil], particles.layer[soil]
    depth = scene.geometry.ground(x) - y
    total, effective = scene.gravity.acceleration * overburden(scene, x, y), effective_overburden(scene, x, y)
    peak = peak_of(scene)
    if peak == 0.0:
        return []
    sand = can_liquefy(scene, x, y, layer)
    strength, reached = peak_strength(scene, particles)[0, soil], (depth <= LARGEST_DEPTH) & (effective > 0.0)
    by_layer = []
    for number, (name, of) in enumerate(zip(("soil", *scene.layers), scene.soils, strict=True)):
        is_clay = of.friction_angle == 0.0
        there = np.flatnonzero((layer == number) & reached & (sand | is_clay))
        if not there.size:
            continue
        stress = 0.65 * peak / GRAVITY * total[there] / effective[there] * stress_reduction(depth[there], magnitude)
        if is_clay:
            resistance = clay_resistance(strength[there] / effective[there], magnitude)
        else:
            resistance = sand_resistance(of.clean_sand_blow_count, magnitude, effective[there])
        by_layer.append(Factors(name, is_clay, depth[there], resistance / stress))
    return by_layer


def peak_of(scene: Scene) -> float:
    """Peak of the horizontal motion, m/s2."""
    return float(np.abs(loading_of(scene).ground).max(initial=0.0))


def of_liquefaction(scene: Scene, particles: Particles, magnitude: float) -> list[Finding]:
    """The least factor of safety of each layer (``factors``)."""
    findings = []
    for layer, is_clay, depth, safety in factors(scene, particles, magnitude):
        worst = int(np.argmin(safety))
        numbers = {"value": float(safety[worst]), "bound": 1.0, "depth": float(depth[worst]), "share": float(np.mean(safety < 1.0))}
        numbers |= {"magnitude": magnitude, "peak": peak_of(scene)}
        findings.append(finding("cyclic-softening" if is_clay else "liquefaction", subject=layer, **numbers))
    return called(findings, scene.soil.name)
