"""The yield surface of a state of the soil: a record of its coefficients, which the solver knows by its type, with the functions below."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sph.solver.compiled.jit import jit
from sph.solver.compiled.slots import slot

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Deviator
    from sph.solver.physics.mohr_coulomb import MohrCoulomb


@slot
def limit_tension(surface: MohrCoulomb, p: float) -> float:
    """Pressure no lower than the apex or the cut-off, Pa."""
    raise NotImplementedError


@slot
def strength(surface: MohrCoulomb, p: float) -> float:
    """Yield shear stress at pressure p (Pa), never negative."""
    raise NotImplementedError


@slot
def shear_demand(surface: MohrCoulomb, s: Deviator) -> float:
    """What a deviator asks of the strength, Pa."""
    raise NotImplementedError


@jit
def return_factor(surface: MohrCoulomb, p: float, s: Deviator) -> float:
    """Factor (<= 1) that brings the deviator to the surface at pressure p; 1 inside or on it."""
    demand = shear_demand(surface, s)
    available = strength(surface, p)
    return available / demand if demand > available else 1.0
