"""Bingham fluid of the fluid state (Eqs. 12 and 13) as a viscous fluid with min(eta + tau_y / rate, cap).

At rest it creeps at tau / cap, for ever; kept so that this difference to the elastic-viscoplastic law can be measured.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.scene.soil import CappedViscosity as Section
from sph.solver.compiled.slots import with_numbers
from sph.solver.optional import Limit
from sph.solver.physics.elasticity import deviator_square, elastic_rate, scaled
from sph.solver.physics.fluid_law import FluidLaw, fluid_deviator
from sph.solver.physics.yield_surface import strength

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Deviator, Strain
    from sph.solver.physics.mohr_coulomb import MohrCoulomb


class CappedViscosity(NamedTuple):
    """Coefficients of the law."""

    viscosity: float
    """eta, Pa s"""
    cap: float
    """largest viscosity, Pa s"""


@fluid_deviator.of(CappedViscosity)
def _deviator(law: CappedViscosity, surface: MohrCoulomb, p: float, s: Deviator, strain: Strain) -> Deviator:
    rate = elastic_rate(1.0, strain)
    shear_rate = math.sqrt(0.5 * deviator_square(rate))
    viscosity = law.cap
    if strength(surface, p) < (law.cap - law.viscosity) * shear_rate:
        viscosity = law.viscosity + strength(surface, p) / shear_rate
    return scaled(rate, viscosity)


@with_numbers.of(CappedViscosity)
def _with_numbers(record: CappedViscosity, table: np.ndarray, k: int, first: int) -> Any:
    return CappedViscosity(table[k, first], table[k, first + 1])


def _limit(scene: Scene) -> Limit:
    """Of the diffusion of momentum."""
    assert isinstance(scene.coupling.fluid, Section)
    cap = scene.coupling.fluid.max_viscosity
    density = min(soil.density for soil in scene.soils)
    return Limit("capped viscosity", 0.125 * scene.numerics.smoothing_length**2 * density / cap, f"eta_max = {cap:.3g} Pa s")


LAW = FluidLaw(CappedViscosity, lambda soil, section: CappedViscosity(float(soil.viscosity), float(section.max_viscosity)), _limit)
