"""Bingham fluid of the fluid state (Eqs. 12 and 13).

Eq. 13 adds a scalar yield stress to a tensor.  It is read as 2 (eta + tau_y / rate) times the
deviatoric strain rate, with rate = sqrt(2 d : d), rigid below tau_y.  Two laws regularise it:

* ``elastic_viscoplastic`` (default): elastic below yield; above it the backward Euler step of
  ds/dt = 2 G (d - d_viscoplastic) has the closed form (tau_y + theta trial) / (1 + theta) with
  theta = eta / (G dt).  It arrests, and it puts no limit on the time step.
* ``capped_viscosity``: a viscous fluid with min(eta + tau_y / rate, cap).  At rest it creeps at
  tau / cap, for ever; kept so that this difference can be measured.

``eta`` = 2 Pa s is negligible beside tau_y >= 15 kPa at the rates of a collapse.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from sph.solver.compiled.jit import jit
from sph.solver.physics.elasticity import deviator_square, elastic_increment, rotate
from sph.solver.physics.mohr_coulomb import shear_demand, strength


class CapTerm(NamedTuple):
    """Capped viscosity in place of elastic strain below yield."""

    viscosity: float
    """largest viscosity, Pa s"""


class FluidLaw(NamedTuple):
    """Coefficients of the fluid state: elastic-viscoplastic unless a cap is given."""

    shear_modulus: float
    """G, Pa"""
    viscosity: float
    """eta, Pa s"""
    cap: CapTerm | None


@jit
def _elastic_viscoplastic(law, surface, p, d, q, z, d_xx, d_yy, d_xy, angle, dt):  # type: ignore[no-untyped-def]
    d, q = rotate(d, q, angle)
    rate_d, rate_q, rate_z = elastic_increment(law.shear_modulus, d_xx, d_yy, d_xy)
    d += rate_d * dt
    q += rate_q * dt
    z += rate_z * dt
    demand = shear_demand(surface, d, q, z)
    yield_stress = strength(surface, p)
    factor = 1.0
    theta = law.viscosity / (law.shear_modulus * dt)
    if demand > yield_stress:
        factor = (yield_stress + theta * demand) / ((1.0 + theta) * demand)
    return d * factor, q * factor, z * factor


@jit
def _capped_viscosity(cap, law, surface, p, d_xx, d_yy, d_xy):  # type: ignore[no-untyped-def]
    rate_d, rate_q, rate_z = elastic_increment(1.0, d_xx, d_yy, d_xy)
    shear_rate = math.sqrt(0.5 * deviator_square(rate_d, rate_q, rate_z))
    viscosity = cap.viscosity
    if strength(surface, p) < (cap.viscosity - law.viscosity) * shear_rate:
        viscosity = law.viscosity + strength(surface, p) / shear_rate
    return rate_d * viscosity, rate_q * viscosity, rate_z * viscosity


@jit
def _fluid_deviator(cap, law, surface, p, d, q, z, d_xx, d_yy, d_xy, angle, dt):  # type: ignore[no-untyped-def]
    if cap is None:
        return _elastic_viscoplastic(law, surface, p, d, q, z, d_xx, d_yy, d_xy, angle, dt)
    else:
        return _capped_viscosity(cap, law, surface, p, d_xx, d_yy, d_xy)


@jit
def fluid_deviator(law, surface, p, d, q, z, d_xx, d_yy, d_xy, angle, dt):  # type: ignore[no-untyped-def]
    """New deviator (d, q, z) (Pa) of the fluid state after a step of strain rates (1/s) and spin ``angle``."""
    return _fluid_deviator(law.cap, law, surface, p, d, q, z, d_xx, d_yy, d_xy, angle, dt)
