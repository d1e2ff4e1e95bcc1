"""Artificial viscosity in the signal-speed form of Monaghan (1997).

It acts along the line between two approaching particles, with alpha V_p times their approach speed:

    a_i += alpha V_p / rho_0 sum_j min(u, 0) g_ij,   u = (v_j - v_i) . n,   n from i to j.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.slots import slot
from sph.solver.optional import Damping, Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel, Lattice, lattice_of
from sph.solver.physics.material import mean_impedance

if TYPE_CHECKING:
    from sph.solver.physics.material import Layers


class ArtificialViscosity(NamedTuple):
    """Coefficients of the term."""

    speed: float
    """alpha V_p over the reference density, m4/(s kg)"""


@slot
def dissipation(viscosity: ArtificialViscosity | None, layers: Layers | None, i: int, j: int, opening: float, inverse_norm: float) -> float:
    """What a pair adds to the sum for artificial viscosity, over its g; only approaching pairs (opening < 0) dissipate."""
    return 0.0


@dissipation.of(ArtificialViscosity)
def _dissipation(viscosity: ArtificialViscosity, layers: Layers | None, i: int, j: int, opening: float, inverse_norm: float) -> float:
    return mean_impedance(layers, i, j, min(opening, 0.0) * inverse_norm)


@slot
def viscous_acceleration(viscosity: ArtificialViscosity | None, value: float) -> float:
    """Acceleration (m/s2) of a sum over pairs."""
    return 0.0


@viscous_acceleration.of(ArtificialViscosity)
def _viscous_acceleration(viscosity: ArtificialViscosity, value: float) -> float:
    return viscosity.speed * value


def viscous_rate(scene: Scene, lattice: Lattice | None = None) -> float:
    """Rate at which artificial viscosity damps the stiffest mode, 1/s; with layers a bound: the lightest beside the largest impedance."""
    if scene.numerics.artificial_viscosity is None:
        return 0.0
    x, volume, factor = lattice_of(scene) if lattice is None else lattice
    speed = max(soil.density * soil.p_wave_speed for soil in scene.soils) / min(soil.density for soil in scene.soils)
    return scene.numerics.artificial_viscosity.alpha * speed * volume * float(np.abs(factor * x).sum())


def coefficient(scene: Scene) -> float:
    """alpha V_p over the reference density, m4/(s kg)."""
    assert scene.numerics.artificial_viscosity is not None
    return float(scene.numerics.artificial_viscosity.alpha * scene.soil.p_wave_speed / scene.soil.density)


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> ArtificialViscosity:
    return ArtificialViscosity(coefficient(scene))


def damping(scene: Scene, lattice: Lattice, omega: float) -> Damping:
    """What the term adds to the damping of the stiffest mode."""
    assert scene.numerics.artificial_viscosity is not None
    rate = viscous_rate(scene, lattice)
    return Damping(rate / omega, "with artificial viscosity", f"alpha = {scene.numerics.artificial_viscosity.alpha}")


TERM = Term(
    "artificial_viscosity",
    "numerics.artificial_viscosity",
    lambda scene: scene.numerics.artificial_viscosity is not None and scene.numerics.artificial_viscosity.reconstruction == "none",
    _make,
    damping=damping,
)
