"""The law of the fluid state: how its deviator follows the strain rate.

A law is a record of coefficients, which the solver knows by its type, with the functions below.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.solver.compiled.slots import slot
from sph.solver.optional import Limit

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Deviator, Strain
    from sph.solver.physics.mohr_coulomb import MohrCoulomb


class FluidLaw(NamedTuple):
    """What the solver is told of a law."""

    record: type
    """of its coefficients"""
    make: Callable[[Soil, Any], Any]
    """the record, from a soil and the scene's section ``coupling.fluid``"""
    limit: Callable[[Scene], Limit] | None = None
    """of the time step, beside that of elastic waves"""


@slot
def fluid_deviator(law: Any, surface: MohrCoulomb, p: float, s: Deviator, strain: Strain) -> Deviator:
    """New deviator (Pa) of the fluid state after a step, from its pressure p and deviator s (Pa)."""
    raise NotImplementedError
