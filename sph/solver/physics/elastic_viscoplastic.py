"""Bingham fluid of the fluid state (Eqs. 12 and 13), elastic below its yield stress.

Eq. 13 adds a scalar yield stress to a tensor.  It is read as 2 (eta + tau_y / rate) times the
deviatoric strain rate, with rate = sqrt(2 d : d), rigid below tau_y.  This law regularises it: it is elastic below yield;
above it the backward Euler step of ds/dt = 2 G (d - d_viscoplastic) has the closed form
(tau_y + theta trial) / (1 + theta) with theta = eta / (G dt).  It arrests, and it puts no limit on the time step.

``eta`` = 2 Pa s is negligible beside tau_y >= 15 kPa at the rates of a collapse.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.solver.compiled.slots import with_numbers
from sph.solver.physics.elasticity import elastic_rate, scaled, strained
from sph.solver.physics.fluid_law import FluidLaw, fluid_deviator
from sph.solver.physics.yield_surface import shear_demand, strength

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Deviator, Strain
    from sph.solver.physics.mohr_coulomb import MohrCoulomb


class ElasticViscoplastic(NamedTuple):
    """Coefficients of the law."""

    shear_modulus: float
    """G, Pa"""
    viscosity: float
    """eta, Pa s"""


@fluid_deviator.of(ElasticViscoplastic)
def _deviator(law: ElasticViscoplastic, surface: MohrCoulomb, p: float, s: Deviator, strain: Strain) -> Deviator:
    trial = strained(s, elastic_rate(law.shear_modulus, strain), strain)
    demand = shear_demand(surface, trial)
    yield_stress = strength(surface, p)
    factor = 1.0
    theta = law.viscosity / (law.shear_modulus * strain.dt)
    if demand > yield_stress:
        factor = (yield_stress + theta * demand) / ((1.0 + theta) * demand)
    return scaled(trial, factor)


@with_numbers.of(ElasticViscoplastic)
def _with_numbers(record: ElasticViscoplastic, table: np.ndarray, k: int, first: int) -> Any:
    return ElasticViscoplastic(table[k, first], table[k, first + 1])


LAW = FluidLaw(ElasticViscoplastic, lambda soil, section: ElasticViscoplastic(float(soil.shear_modulus_si), float(soil.viscosity)))
