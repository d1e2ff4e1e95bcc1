"""What may be wrong with how soil loses its strength, found before a run."""

from __future__ import annotations

import math

from sph.checks.finding import Finding, finding
from sph.scene.layers import LayerMaterial
from sph.scene.schema import Scene
from sph.stability.standing import slope_height

MIN_IN_LENGTH = 3
"""Spacings in the length over which plastic strain is averaged before soil fails."""
MIN_ZONE = 3.0
"""Zone over which slip develops, over the height, from which on the critical amplitude no longer changes with the spacing: measured, with
a zone of 0.8 heights it falls by 30 %, with 4 and more by 3 % at most from 20 rows over the height on (docs/model/softening.md)."""


def slip_zone(scene: Scene, material: LayerMaterial) -> float:
    """Length over which slip develops, G (s_r - s_p) / (tau_p - tau_r), at half the slope's weight, m; infinite where no strength is lost.

    Palmer and Rice (1973).  The scene's strength is lost by slip.
    """
    softening, material = material.softening, material.at_depth(0.5 * slope_height(scene))
    assert softening is not None and softening.slip_at_residual is not None
    soil, (cohesion, angle) = material.soil, material.residual
    stress = 0.5 * soil.density * scene.gravity.acceleration * slope_height(scene)
    lost = soil.cohesion_si - 1e3 * cohesion + stress * (math.tan(soil.friction_angle_si) - math.tan(math.radians(angle)))
    return soil.shear_modulus_si * (softening.slip_at_residual - softening.slip_at_peak) / lost if lost > 0.0 else math.inf


def of_loss(scene: Scene) -> list[Finding]:
    """Findings of how strength is lost after the peak: with time on the user's own slope, with both, or with slip over too short a zone."""
    rates = {"coupling.gamma": scene.coupling.gamma, **{f"layers.{name}.gamma": its.gamma or 0.0 for name, its in scene.layers.items()}}
    key, rate = max(rates.items(), key=lambda pair: pair[1])
    if not scene.coupling.softens_by_slip:
        told = finding("lost-by-time", "coupling.softening.slip_at_residual", value=rate)
        return [told] if scene.scheme != "paper" and rate > 0 else []
    findings = [finding("lost-by-time", key, value=rate, bound=0.0)] if rate > 0 else []
    length, name = min((slip_zone(scene, material), material.name) for material in scene.materials)
    bound = MIN_ZONE * slope_height(scene)
    if length < bound:
        key = "coupling.softening.slip_at_residual"
        findings.append(finding("progressive-failure", key, subject=name, value=length, bound=bound, heights=MIN_ZONE))
    return findings


def of_softening(scene: Scene) -> list[Finding]:
    """A finding if strength falls over no width, as in the paper's scheme, or over one that is narrower than particles can average."""
    softening, dx = scene.coupling.softening, scene.numerics.spacing
    if softening is None:
        return [finding("no-process-zone", "coupling.softening", paper=scene.scheme == "paper")]
    if softening.width >= MIN_IN_LENGTH * dx * (1 - 1e-9):
        return []
    keys, width = ("numerics.spacing", "coupling.softening.width"), softening.width
    return [finding("short-process-zone", *keys, value=width / dx, bound=MIN_IN_LENGTH, width=width)]
