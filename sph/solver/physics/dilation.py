"""Dilation of intact soil at yield: plastic flow with a dilation angle psi (Mohr-Coulomb potential in plane strain).

Plastic shear strain lambda comes with the increase of volume lambda sin(psi).  The density is that of the elastic part of the volume, from
which the pressure follows; so it grows where soil dilates and cannot expand.  With the bulk modulus K the trial stress returns
to the surface by

    lambda = (demand - strength) / (G + K sin(phi) sin(psi)),   dp = K lambda sin(psi).

Without this term plastic flow keeps the volume.  With psi = phi the flow is associated, as limit analysis takes it.  Dilation fades with
beta: soil that has failed is at its critical state.  The out-of-plane deviator is left out of lambda; the return that follows is exact
at the pressure found.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.yield_surface import shear_demand, strength

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Deviator
    from sph.solver.physics.material import Material
    from sph.solver.terms import State


class Dilation(NamedTuple):
    """Coefficients of the term."""

    flow: np.ndarray
    """(particles with a stress of their own,) sin(psi)"""
    friction: np.ndarray
    """the same of sin(phi)"""


@slot
def dilate(dilation: Dilation | None, state: State, soil: Material, i: int, p: float, s: Deviator) -> float:
    """Pressure (Pa) after the dilation of particle i in a step, from its pressure p and trial deviator s (Pa); notes the density."""
    return p


@dilate.of(Dilation)
def _dilate(dilation: Dilation, state: State, soil: Material, i: int, p: float, s: Deviator) -> float:
    excess = max(shear_demand(soil.solid, s) - strength(soil.solid, p), 0.0)
    growth = state.beta[i] * excess * dilation.flow[i] / (soil.shear_modulus + soil.bulk_modulus * dilation.friction[i] * dilation.flow[i])
    state.density[i] *= 1.0 + growth
    return p + (soil.bulk_modulus + p) * growth


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Dilation:
    layer = particles.layer[: particles.first_no_slip]
    psi, phi = (np.radians([getattr(soil, name) for soil in scene.soils]) for name in ("dilation_angle", "friction_angle"))
    return Dilation(np.sin(psi)[layer], np.sin(phi)[layer])


def _wanted(scene: Scene) -> bool:
    return any(soil.dilation_angle > 0 for soil in scene.soils)


TERM = Term("dilation", "soil.dilation_angle: soil at yield dilates", _wanted, _make)
