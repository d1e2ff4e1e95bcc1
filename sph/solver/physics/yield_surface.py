"""The yield surface of a state of the soil: a record of its coefficients, which the solver knows by its type, with the functions below."""

from __future__ import annotations

from sph.solver.compiled.jit import jit
from sph.solver.compiled.slots import slot


@slot
def limit_tension(surface, p):  # type: ignore[no-untyped-def]
    """Pressure no lower than the apex or the cut-off, Pa."""


@slot
def strength(surface, p):  # type: ignore[no-untyped-def]
    """Yield shear stress at pressure p (Pa), never negative."""


@slot
def shear_demand(surface, s):  # type: ignore[no-untyped-def]
    """What a deviator asks of the strength, Pa."""


@jit
def return_factor(surface, p, s):  # type: ignore[no-untyped-def]
    """Factor (<= 1) that brings the deviator to the surface at pressure p; 1 inside or on it."""
    demand = shear_demand(surface, s)
    available = strength(surface, p)
    return available / demand if demand > available else 1.0
